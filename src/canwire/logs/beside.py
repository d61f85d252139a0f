"""A temporary file next to its target: the target is replaced only when the new file is complete."""

from __future__ import annotations

import errno
import itertools
import os
import shutil
from contextlib import suppress

_numbers = itertools.count(1)


class Beside:
    """`made` is the name to write to. `take_place` gives it the name `path`, `give_up` removes it.

    It keeps the suffix, and the permissions of a replaced file; a link stays, and its target is replaced. A pipe, a
    device or a folder is written directly: then `made` is `path`. Raises PermissionError for a file that may not be
    written.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._target = os.path.realpath(path)
        there = os.path.exists(self._target)
        if there and not os.access(self._target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)
        plain = not there or os.path.isfile(self._target)
        self.made = _name_beside(self._target) if plain else path

    def take_place(self) -> None:
        """Give the file its final name. If it raises OSError, nothing has changed."""
        if self.made != self.path:
            with suppress(FileNotFoundError):
                shutil.copymode(self._target, self.made)
            os.replace(self.made, self._target)

    def give_up(self) -> None:
        """Remove the file, and the journal of a database; a second call does nothing."""
        if self.made != self.path:
            for name in (self.made, f"{self.made}-journal"):
                with suppress(FileNotFoundError):
                    os.remove(name)

    def __enter__(self) -> str:
        return self.made

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, OSError) and error.filename == self.made:
            error.filename = self.path
        try:
            if error is None:
                self.take_place()
        finally:
            self.give_up()


def _name_beside(path: str) -> str:
    """Return a name that no other process uses, and no other log of this process."""
    stem, suffix = os.path.splitext(path)
    return f"{stem}.new-{os.getpid()}-{next(_numbers)}{suffix}"
