"""The limits of one client of a hub, and the errors at these limits or at those of the system."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator

from canwire.boards.config.limits import LimitsConfig
from canwire.errors import LimitReached
from canwire.platform import descriptor_limit

_NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE, errno.ETOOMANYREFS)
_NO_MEMORY = (errno.ENOMEM, errno.ENOBUFS, errno.ENOSPC)


def check_room(limits: LimitsConfig, name: str, used: int, who: str, more: int = 1) -> None:
    """Raises LimitReached if `more` would exceed the limit of this name."""
    limit: int = getattr(limits, name)
    if used + more > limit:
        raise LimitReached(
            f"{who} has {used} of {limit} {name} of this hub; close some, or set {name} under [limits] "
            f"in its canwire.toml"
        )


@contextlib.contextmanager
def enough(what: str) -> Iterator[None]:
    """A context in which a lack of descriptors or memory raises LimitReached, which only ends the request."""
    try:
        yield
    except OSError as error:
        if error.errno in _NO_DESCRIPTORS:
            raise LimitReached(no_descriptors(what)) from error
        if error.errno in _NO_MEMORY:
            raise LimitReached(
                f"{what}: the hub is out of memory ({error.strerror}); ask for less"
            ) from error
        raise
    except MemoryError as error:
        raise LimitReached(f"{what}: the hub is out of memory; ask for less") from error


def no_descriptors(what: str) -> str:
    """The error message if the hub has used all its descriptors."""
    return (
        f"{what}: the hub has used all of its {descriptor_limit()} descriptors; close channels or FIFOs, "
        f"or start it with more (ulimit -n)"
    )
