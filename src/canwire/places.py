"""The directories for a user's sockets, and for files that remain after the programs end."""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from collections.abc import Iterator


def runtime_directory() -> str:
    """The directory for this user's sockets: XDG_RUNTIME_DIR, or a private directory in the temporary directory."""
    given = os.environ.get("XDG_RUNTIME_DIR")
    if given and os.path.isdir(given):
        _check_given(given)
        return given
    import tempfile  # some milliseconds that few need

    if not hasattr(os, "getuid"):  # Windows: below the user's profile, whose rights it inherits
        own = os.path.join(state_directory(), "run")
        os.makedirs(own, exist_ok=True)
        return own
    own = os.path.join(tempfile.gettempdir(), f"canwire-{os.getuid()}")
    os.makedirs(own, mode=0o700, exist_ok=True)
    state = os.lstat(own)
    if not stat.S_ISDIR(state.st_mode) or state.st_uid != os.getuid() or state.st_mode & 0o077:
        raise PermissionError(
            f"{own}: not a private directory of this user; remove it or set XDG_RUNTIME_DIR"
        )
    return own


def _check_given(path: str) -> None:
    """Raises PermissionError if another user could replace our sockets."""
    if not hasattr(os, "getuid"):
        return
    state = os.stat(path)
    if os.getuid() not in (0, state.st_uid):
        raise PermissionError(
            f"XDG_RUNTIME_DIR={path}: it belongs to user {state.st_uid}; set it to one of your own"
        )
    if state.st_mode & 0o022 and not state.st_mode & stat.S_ISVTX:
        raise PermissionError(f"XDG_RUNTIME_DIR={path}: others may write there; chmod go-w {path}")


def state_directory() -> str:
    """The directory for files that remain after programs end: XDG_STATE_HOME, ~/.local/state, or the system's."""
    if sys.platform == "win32":
        usual = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        usual = "~/Library/Application Support"
    else:
        usual = "~/.local/state"
    given = os.environ.get("XDG_STATE_HOME", "")
    return os.path.join(given if os.path.isabs(given) else os.path.expanduser(usual), "canwire")


@contextlib.contextmanager
def locked_directory(path: str) -> Iterator[None]:
    """Lock the directory against other programs that call this; the lock ends with the process at the latest."""
    import fcntl  # not everywhere, and needed by hubs on Unix sockets alone

    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
