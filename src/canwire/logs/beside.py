"""A file beside the one whose place it takes: until it is whole, what was there stays as it was."""

from __future__ import annotations

import errno
import itertools
import os
import shutil
from contextlib import suppress

_numbers = itertools.count(1)


class Beside:
    """`made` is the name to write to. `take_place` gives it the name `path`, `give_up` removes it.

    It keeps the suffix, and the permissions of a file that it replaces; a link stays, and what it points to is
    replaced. What is no file (a pipe, a device, a folder) is written itself: `made` is `path` then.
    Raises PermissionError for a file that may not be written.
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
        """Raises OSError, and nothing has changed then."""
        if self.made != self.path:
            with suppress(FileNotFoundError):
                shutil.copymode(self._target, self.made)
            os.replace(self.made, self._target)

    def give_up(self) -> None:
        """Nothing of it is left, of a database its journal neither; a second time does nothing."""
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
    """One that no other process and no other log of this one takes."""
    stem, suffix = os.path.splitext(path)
    return f"{stem}.new-{os.getpid()}-{next(_numbers)}{suffix}"
