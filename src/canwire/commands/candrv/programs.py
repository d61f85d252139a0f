"""CanWrite, CanRead and CanMon of the CANDRV manual. CanMon's lines, of which the manual has no listing, are

    time event lost frame identifier rtr dlc data...       12568 RECEIVED 0 STD 00000112 0 4 11 22 33 44

with all after `lost` only where there is a message; numbers decimal but for identifier, dlc and data.
Source: CANDRV manual, 10.1 to 10.3.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from typing import IO, TYPE_CHECKING

from canwire import CanwireError
from canwire.commands.candrv.opening import (
    MESSAGES,
    OK,
    failed,
    hub_of,
    log_file,
    open_device,
    point_out,
    say,
    set_rate,
)
from canwire.commands.candrv.switches import Switches
from canwire.commands.candrv.work import work
from canwire.commands.console import complain

if TYPE_CHECKING:
    from canwire.candrv import Handle
    from canwire.candrv.event_queue import Event

READ_BUFFER = 100  # characters, as CanRead has it; the longest event takes fewer


def can_write(switches: Switches, closing: ExitStack) -> int:
    """Send 1000 messages with increasing identifiers."""
    hub = hub_of(switches, closing)
    with open_device(switches, hub) as query:
        rate = set_rate(switches, query)
    with open_device(switches, hub, read=True, write=True) as device, log_file(switches) as log:
        point_out(device)
        start = f"Start sending {MESSAGES} messages to {switches.device}, baudrate={rate} Hz"
        try:
            written = Written(switches.device)
            work(lambda: _write_all(device, start, log, written), device.close, written.look)
        except CanwireError as error:
            raise failed("Write error", error) from error
    return OK


class Written:
    """How many messages CanWrite has sent. It reports once that sending has stopped, perhaps for want of a receiver."""

    def __init__(self, device: str) -> None:
        self.count = self._before = 0
        self._device = device
        self._told = False

    def look(self) -> None:
        """Between two looks a bus that takes messages takes some."""
        if self.count == self._before and not self._told:
            self._told = True
            complain(
                f"{self._device}: message {self.count} of {MESSAGES} waits: the bus takes none; does another "
                "controller run there? Ctrl-C ends it"
            )
        self._before = self.count


def _write_all(device: Handle, start: str, log: IO[bytes] | None, written: Written) -> None:
    say(start)
    for number in range(MESSAGES):
        line = f"{number:x} 0 8 0 0 0 0 0 0 0 0\n".encode()
        device.write_text(line)
        written.count = number + 1
        if log is not None:
            log.write(line)


def can_read(switches: Switches, closing: ExitStack) -> int:
    """Print all events as ReadFile returns them, until Ctrl-C."""
    return _receive(switches, closing, lambda device: device.read_text(READ_BUFFER))


def can_mon(switches: Switches, closing: ExitStack) -> int:
    """Print all events of the binary interface, until Ctrl-C."""
    return _receive(switches, closing, lambda device: f"{shown(device.read_event())}\n".encode())


def _receive(switches: Switches, closing: ExitStack, read: Callable[[Handle], bytes]) -> int:
    hub = hub_of(switches, closing)
    with open_device(switches, hub, read=True) as device:
        rate = set_rate(switches, device)
        device.accept_all()
        point_out(device)
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
