"""Files are treated as Windows has it: what is open can be neither removed nor replaced. Packages may be missing."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

_OPEN = Path("/proc/self/fd")
_NEEDS = {"parquet": "pyarrow", "trace": "pyarrow", "mf4": "asammdf"}


@pytest.fixture(autouse=True)
def _packages_of_its_format(request: pytest.FixtureRequest) -> None:
    """A test that is repeated for each format is skipped for those whose packages are missing."""
    callspec = getattr(request.node, "callspec", None)
    for value in callspec.params.values() if callspec else ():
        if isinstance(value, str) and value.lstrip(".") in _NEEDS:
            pytest.importorskip(_NEEDS[value.lstrip(".")])


@pytest.fixture(autouse=os.name == "posix" and _OPEN.is_dir())
def _open_files_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    """In this process they do so on Linux too, which else shows nothing of a file that was closed too late."""
    for name in ("remove", "unlink", "replace", "rename"):
        monkeypatch.setattr(os, name, _refusing(getattr(os, name)))


def _refusing(call: Callable[..., None]) -> Callable[..., None]:
    def refusing(*paths: str, **options: int) -> None:
        for path in paths:
            if not options and os.path.isfile(path) and _is_open(path):
                raise PermissionError(errno.EACCES, "open files are neither removed nor replaced", path)
        call(*paths, **options)

    return refusing


def _is_open(path: str) -> bool:
    try:
        return any(os.path.samefile(each, path) for each in _OPEN.iterdir() if each.is_file())
    except FileNotFoundError:  # one of another thread's was closed meanwhile
        return _is_open(path)
