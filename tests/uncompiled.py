"""A second copy of the package, imported from its .py sources alone beside the installed one."""

from __future__ import annotations

import contextlib
import importlib
import sys
from collections.abc import Iterator, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import SOURCE_SUFFIXES, FileFinder, ModuleSpec, SourceFileLoader
from pathlib import Path
from types import ModuleType


class SourcesOnly(MetaPathFinder):
    """Finds one package's modules as sources, whatever extension modules lie beside them."""

    def __init__(self, package: str, home: Path) -> None:
        self.package = package
        self.home = home

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.partition(".")[0] != self.package:
            return None
        for folder in [str(self.home)] if path is None else path:
            found = FileFinder(folder, (SourceFileLoader, SOURCE_SUFFIXES)).find_spec(fullname)
            if found is not None:
                return found
        raise ModuleNotFoundError(f"{fullname} has no source", name=fullname)


@contextlib.contextmanager
def load_uncompiled(package: ModuleType) -> Iterator[ModuleType]:
    """An interpreted twin of an imported package; use it inside the `with` block only.

    In there sys.modules knows only the twin's modules, so that what it imports late is its own.
    """
    name = package.__name__
    finder = SourcesOnly(name, Path(str(package.__file__)).parents[1])
    installed = taken_out(name)
    sys.meta_path.insert(0, finder)
    try:
        yield importlib.import_module(name)
    finally:
        sys.meta_path.remove(finder)
        taken_out(name)
        sys.modules.update(installed)


def taken_out(package: str) -> dict[str, ModuleType]:
    """The package's modules, removed from sys.modules."""
    names = [name for name in sys.modules if name.partition(".")[0] == package]
    return {name: sys.modules.pop(name) for name in names}
