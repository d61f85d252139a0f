"""Error messages for an adapter that cannot be opened, which say what to do; for serial ports and for python-can.

Each library reports the same few causes differently: by an errno, a class, or only a sentence.
"""

from __future__ import annotations

import errno
import sys
from collections.abc import Iterable
from difflib import get_close_matches

_DENIED = ("permission denied", "access denied", "insufficient permissions", "operation not permitted")
_BUSY = ("resource busy", "already in use", "could not exclusively lock", "device is busy", "net is occupied")
_ABSENT = (
    "no such device",
    "no such file",
    "cannot find device",
    "not found",
    "could not open port",
    "handle is not valid",
    "not available",
)
_USB = (
    "put the line SUBSYSTEM==\"usb\", ATTR{idVendor}==\"1d50\", ATTR{idProduct}==\"606f\", TAG+=\"uaccess\" with your "
    "adapter's two numbers (`lsusb` shows them) into /etc/udev/rules.d/70-canwire.rules, call "
    "`sudo udevadm control --reload`, and plug it in again"
)  # fmt: skip
_PORT = "add your user to the group that owns it (`sudo usermod -aG dialout $USER`) and log in again"


def codes_of(error: BaseException) -> set[int]:
    """The errnos of this exception and of those that caused it."""
    found: set[int] = set()
    seen: BaseException | None = error
    while seen is not None:
        number = getattr(seen, "errno", None)
        if isinstance(number, int):
            found.add(number)
        seen = seen.__cause__ or seen.__context__
    return found


def text_of(error: BaseException) -> str:
    """The text of this exception, or the name of its class if it has none."""
    return str(error) or type(error).__name__


def is_denied(error: BaseException) -> bool:
    """True if the system refused access."""
    return bool(codes_of(error) & {errno.EACCES, errno.EPERM}) or _says(error, _DENIED)


def is_busy(error: BaseException) -> bool:
    """True if another program has the adapter open."""
    return bool(codes_of(error) & {errno.EBUSY, errno.EAGAIN}) or _says(error, _BUSY)


def is_absent(error: BaseException) -> bool:
    """True if the adapter does not exist."""
    return bool(codes_of(error) & {errno.ENOENT, errno.ENODEV, errno.ENXIO}) or _says(error, _ABSENT)


def denied(what: str, *, usb: bool) -> str:
    """The message for a refused access: how to get the permission on this system."""
    way = "run as an administrator"
    if sys.platform.startswith("linux"):
        way = _USB if usb else _PORT
    return f"no permission to open {what}: {way}"


def busy(what: str) -> str:
    """The message for an adapter that another program has open."""
    return f"{what} is busy: another program has it open; end that program, or have it use the hub"


def absent(what: str, found: Iterable[str], name: str = "") -> str:
    """The message for a missing adapter, with those that were found; `name` is its name in that list ("": `what`)."""
    there = list(found)
    near = get_close_matches(name or what, there, 1)
    meant = f"; did you mean {near[0]}?" if near else ""
    return f"there is no {what}; found: {', '.join(there) or 'none'}{meant}"


def _says(error: BaseException, words: tuple[str, ...]) -> bool:
    text = str(error).lower()
    return any(word in text for word in words)
