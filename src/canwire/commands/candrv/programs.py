"""CanWrite, CanRead and CanMon of the CANDRV manual: switches, output, log lines and exit codes are the manual's.

Ours are a line on stderr with the cause of each error, and that what fails ends with 1: the manual's listings go on at
the old rate, and forget messages that could not be written. CanMon's lines, told by no listing, are

    time event lost frame identifier rtr dlc data...       12568 RECEIVED 0 STD 00000112 0 4 11 22 33 44

with all after `lost` only where there is a message; numbers decimal but for identifier, dlc and data.
Source: CANDRV manual (seed 000), 10.1 to 10.3.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING

from canwire import CanwireError
from canwire.commands.candrv.switches import Program, Switches, Usage, parse
from canwire.commands.candrv.work import work
from canwire.commands.hub_line import complain, connected, let_terminate

if TYPE_CHECKING:
    from canwire import Hub
    from canwire.candrv import Handle
    from canwire.candrv.event_queue import Event

MESSAGES = 1000
READ_BUFFER = 100  # characters, as CanRead has it; the longest event takes fewer
OK, DEVICE_ERROR, USAGE = 0, 1, 2
_ERRNO_AS_WIN32 = {2: 3, 13: 5, 20: 3, 21: 5}  # no such directory, no access: as CreateFile tells it


class Failure(Exception):
    """The device is not there or fails: the line that says so."""


def run(arguments: argparse.Namespace) -> int:
    """One program with its words: 0, 1 or 2."""
    program: Program = arguments.candrv_program
    say(f"{program.name} V3.0")
    try:
        switches = parse(program, arguments.words)
    except Usage as wrong:
        say("\n".join(filter(None, (str(wrong), program.usage))))
        return USAGE
    with ExitStack() as closing:
        let_terminate(closing)
        try:
            return program.body(switches, closing)
        except Failure as failure:
            say(str(failure))
            return DEVICE_ERROR


def say(line: str) -> None:
    """A line for whoever reads the program's output."""
    print(line, flush=True)


# the device


def open_device(switches: Switches, hub: Hub, *, read: bool = False, write: bool = False) -> Handle:
    """The device; raises Failure."""
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
    """The shared hub; raises Failure."""
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


@contextmanager
def log_file(switches: Switches) -> Iterator[IO[bytes] | None]:
    """The log file, written through; None where none is wanted, or none can be."""
    if switches.log is None:
        yield None
        return
    try:
        file = Path(switches.log).open("wb", buffering=0)  # noqa: SIM115 - `with` stands below, its errors are others
    except OSError as error:
        complain(f"{switches.log}: {error.strerror}")
        say(f"Can't open log file '{switches.log}', error {_ERRNO_AS_WIN32.get(error.errno or 0, 31)}")
        yield None
        return
    say(f"Using log file '{switches.log}'")
    with file:
        yield file


# the programs


def can_write(switches: Switches, closing: ExitStack) -> int:
    """1000 messages with increasing identifiers."""
    hub = hub_of(switches, closing)
    with open_device(switches, hub) as query:
        rate = set_rate(switches, query)
    with open_device(switches, hub, read=True, write=True) as device, log_file(switches) as log:
        start = f"Start sending {MESSAGES} messages to {switches.device}, baudrate={rate} Hz"
        try:
            work(lambda: _write_all(device, start, log), device.close)
        except CanwireError as error:
            raise failed("Write error", error) from error
    return OK


def _write_all(device: Handle, start: str, log: IO[bytes] | None) -> None:
    say(start)
    for number in range(MESSAGES):
        line = f"{number:x} 0 8 0 0 0 0 0 0 0 0\n".encode()
        device.write_text(line)
        if log is not None:
            log.write(line)


def can_read(switches: Switches, closing: ExitStack) -> int:
    """All events as ReadFile gives them, until Ctrl-C."""
    return _receive(switches, closing, lambda device: device.read_text(READ_BUFFER))


def can_mon(switches: Switches, closing: ExitStack) -> int:
    """All events of the binary interface, until Ctrl-C."""
    return _receive(switches, closing, lambda device: f"{shown(device.read_event())}\n".encode())


def _receive(switches: Switches, closing: ExitStack, read: Callable[[Handle], bytes]) -> int:
    hub = hub_of(switches, closing)
    with open_device(switches, hub, read=True) as device:
        rate = set_rate(switches, device)
        device.accept_all()
        with log_file(switches) as log:
            start = f"Start receiving events from {switches.device}, baudrate={rate} Hz"
            try:
                work(lambda: _show_all(lambda: read(device), start, log), device.close)
            except KeyboardInterrupt:
                return OK
            except CanwireError as error:
                raise failed("Read error", error) from error
    return OK


def _show_all(read: Callable[[], bytes], start: str, log: IO[bytes] | None) -> None:
    say(start)
    while True:
        text = read()
        if log is not None:
            log.write(text)
        sys.stdout.write(text.decode("ascii"))
        sys.stdout.flush()


def shown(event: Event) -> str:
    """An event as CanMon prints it."""
    from canwire.candrv.constants import CanbusEvent, FrameFormat

    try:
        name = CanbusEvent(event.event).name or ""
    except ValueError:
        name = ""
    if not name or "|" in name:
        name = f"UNKNOWN_{event.event:X}"
    head = f"{event.time} {name} {event.lost}"
    if not event.has_message:
        return head
    frame = "EXT" if event.fmt == FrameFormat.EXT else "STD"
    data = "".join(f" {byte:02X}" for byte in event.data)
    return f"{head} {frame} {event.identifier:08X} {event.rtr} {event.dlc:X}{data}"


def _can_send(switches: Switches, closing: ExitStack) -> int:
    from canwire.commands.candrv import stress as candrv_stress

    return candrv_stress.can_send(switches, closing)


_COMMON = (
    ("d", "<dev>", "Device name (CID1:)"),
    ("b", "<baud>", "Set baudrate"),
    ("f", "<name>", "Log file name"),
)
_STRESS = (
    ("n", "<num>", f"Messages of each thread ({MESSAGES})"),
    ("c", "<num>", "Send channels (1)"),
    ("t", "<num>", "Threads on each channel (1)"),
)
PROGRAMS = {
    "write": Program(
        "CanWrite", "CanWrite: send 1000 messages with increasing identifiers", _COMMON, can_write
    ),
    "read": Program("CanRead", "CanRead: show all events as ReadFile gives them", _COMMON, can_read),
    "send": Program("CanSend", "CanSend: stress the driver", (*_COMMON, *_STRESS), _can_send),
    "mon": Program("CanMon", "CanMon: show all events of the binary interface", _COMMON, can_mon),
}
