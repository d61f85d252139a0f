"""What the programs of CanTestSuite begin with: the hub, the device, its rate, a log file; and how each one fails.

Source: CANDRV manual, 10.1 to 10.3.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

from canwire import CanwireError
from canwire.commands.can_line import point_out_rates
from canwire.commands.candrv.switches import Switches
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.candrv import Handle

MESSAGES = 1000  # of CanWrite, and of CanSend by default
OK, DEVICE_ERROR, USAGE = 0, 1, 2
_ERRNO_AS_WIN32 = {2: 3, 13: 5, 20: 3, 21: 5}  # no such directory, no access: as CreateFile tells it


class Failure(Exception):
    """The device is not there or fails: the line that says so."""


def say(line: str) -> None:
    """Print a line of the program's output."""
    print(line, flush=True)


def open_device(switches: Switches, hub: Hub, *, read: bool = False, write: bool = False) -> Handle:
    """Open the device; raises Failure."""
    from canwire import candrv

    try:
        return candrv.open(switches.device, read=read, write=write, hub=hub)
    except CanwireError as error:
        raise cannot_open(switches, error) from error


def cannot_open(switches: Switches, error: CanwireError) -> Failure:
    """What the programs say then; the cause goes to stderr."""
    return failed(f"Can't open device {switches.device}, error", error)


def failed(what: str, error: CanwireError) -> Failure:
    """`what` with the Win32 code; the cause goes to stderr."""
    from canwire.candrv.errors import win32_code

    complain(str(error))
    return Failure(f"{what} {win32_code(error)}")


def hub_of(switches: Switches, closing: ExitStack) -> Hub:
    """Connect to the shared hub; raises Failure."""
    try:
        arguments = argparse.Namespace(hub=switches.hub)
        return connected(arguments, f"candrv {switches.program.lower().removeprefix('can')}", closing)
    except CanwireError as error:
        raise cannot_open(switches, error) from error


def set_rate(switches: Switches, handle: Handle) -> int:
    """Set the bit rate that was asked for; the rate that counts now. Raises Failure."""
    try:
        if switches.rate is not None:
            handle.device.change(rate=switches.rate)
        return handle.device.state().rate
    except CanwireError as error:
        raise failed(f"Can't set baudrate {switches.rate}, error", error) from error


def point_out(handle: Handle) -> None:
    """Other controllers of the device's bus at other rates, on stderr."""
    point_out_rates(handle.device.hub, handle.device.line.bus)


@contextmanager
def log_file(switches: Switches) -> Iterator[IO[bytes] | None]:
    """The log file, written through; None where none is wanted, or none can be."""
    if switches.log is None:
        yield None
        return
    try:
        file = Path(switches.log).open("wb", buffering=0)  # noqa: SIM115 - the `with` is below; its errors are different ones
    except OSError as error:
        complain(f"{switches.log}: {error.strerror}")
        say(f"Can't open log file '{switches.log}', error {_ERRNO_AS_WIN32.get(error.errno or 0, 31)}")
        yield None
        return
    say(f"Using log file '{switches.log}'")
    with file:
        yield file
