"""Reading a file by another library: with limits of size and time, and one documented error for all its exceptions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from canwire.errors import BadDescription, CanwireError
from canwire.platform.time_limit import time_limit


@contextmanager
def foreign_reader(file: Path, most_bytes: int, seconds: float, fault: str) -> Iterator[None]:
    """A context that raises BadDescription, with the file's name, for every exception inside except MemoryError.

    A file of more than `most_bytes` is refused; reading may take `seconds`. `fault` is the message for a file that the
    library cannot read. Errors of canwire pass unchanged.
    """
    try:
        if (size := file.stat().st_size) > most_bytes:
            raise BadDescription(f"{file}: {size} bytes, more than most_bytes={most_bytes}")
        with time_limit(
            seconds, lambda: BadDescription(f"{file}: to read it takes longer than seconds={seconds:g}")
        ):
            yield
    except (CanwireError, MemoryError):
        raise
    except OSError as error:
        raise BadDescription(f"{file}: {error.strerror}") from None
    except Exception as error:  # another library's reader may raise anything
        raise BadDescription(f"{file}: {fault} ({type(error).__name__}: {error})"[:400]) from error
