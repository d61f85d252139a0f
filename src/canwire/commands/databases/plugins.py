"""Functions that finish messages: counters, checksums. `module:function`, or the name of an installed plug-in."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable
from importlib.metadata import entry_points

from canwire import BadValue, OutgoingMessage

GROUP = "canwire.simulate"  # of entry points

Plugin = Callable[[OutgoingMessage], None]


def find_plugin(text: str) -> Plugin:
    """The function that `text` names; also finds modules in the current directory. Raises BadValue."""
    module, colon, name = text.partition(":")
    return _of_module(text, module, name) if colon else _installed(text)


def _of_module(text: str, module: str, name: str) -> Plugin:
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    try:
        found = getattr(importlib.import_module(module), name)
    except ImportError as error:
        raise BadValue(f"--plugin {text}: {error}") from None
    except AttributeError:
        raise BadValue(f"--plugin {text}: {module} has no {name!r}") from None
    return _checked(text, found)


def _installed(text: str) -> Plugin:
    there = {point.name: point for point in entry_points(group=GROUP)}
    if text not in there:
        names = ", ".join(sorted(there)) or "none"
        raise BadValue(f"--plugin {text}: module:function, or an installed plug-in's name; there are {names}")
    return _checked(text, there[text].load())


def _checked(text: str, found: object) -> Plugin:
    if not callable(found):
        raise BadValue(f"--plugin {text}: {found!r} cannot be called")
    plugin: Plugin = found
    return plugin
