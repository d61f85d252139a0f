"""What is walked over: the modules of the compiled core and those that programs import, with all in them."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import canwire

HOME = Path(str(canwire.__file__)).parent
PUBLIC = (
    "canwire",
    "canwire.acan",
    "canwire.candrv",
    "canwire.ecus",
    "canwire.packed",
    "canwire.slcan",
    "canwire.vci",
)
WAITS = {
    "canwire.hub.owner.loop.Loop.run": "the thread of a hub, until somebody ends it",
    "canwire.wait": "for a handle",
}
"""What waits without a limit because that is its work."""


def compiled() -> list[str]:
    """Modules that have a `.pxd`, in the order of their names."""
    files = (path.relative_to(HOME.parent).with_suffix("") for path in HOME.rglob("*.pxd"))
    return sorted(".".join(path.parts) for path in files if path.name != "__init__")


def modules() -> list[str]:
    """All that is walked over."""
    return [*compiled(), *PUBLIC]


def classes_of(module: ModuleType) -> Iterator[type]:
    """Those that are the module's own; of a public module all that it names."""
    for thing in vars(module).values():
        if inspect.isclass(thing) and _belongs(thing, module):
            yield thing


def functions_of(module: ModuleType) -> Iterator[tuple[str, Callable[..., Any]]]:
    """As `classes_of`."""
    for name, thing in vars(module).items():
        if callable(thing) and not inspect.isclass(thing) and _belongs(thing, module):
            yield name, thing


def _belongs(thing: object, module: ModuleType) -> bool:
    home = getattr(thing, "__module__", None)
    if module.__name__ in PUBLIC:
        return str(home).startswith("canwire")
    return home == module.__name__


def loaded(name: str) -> ModuleType:
    return importlib.import_module(name)
