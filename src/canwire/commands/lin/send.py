"""`canwire lin send`: frames from a line as its master."""

from __future__ import annotations

import argparse
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import (
    BadValue,
    Busy,
    LinePlace,
    LinErrorKind,
    LinEventKind,
    LinFrame,
    format_lin_frame,
    parse_lin_frame,
)
from canwire.commands.console import complain
from canwire.commands.lin.line import add_lin_arguments, become_master, find_lin_line
from canwire.commands.lin.show import Shown, opened_monitor
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import LinControl, Monitor

_LOOK_S = 0.002  # between two looks whether the line is free


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_lin_arguments(parser)
    parser.add_argument(
        "frames", nargs="+", metavar="FRAME", help="10#0102, 10#0102_C; a header: 10#R, 10#R4"
    )
    parser.add_argument(
        "-n", "--count", type=int, default=1, metavar="COUNT", help="send the whole list COUNT times (1)"
    )
    parser.add_argument(
        "--timeout", type=float, default=1.0, metavar="SECONDS", help="give up on a frame after this long (1)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Send the frames; returns 1 if one of them was not seen on the bus."""
    frames = [parse_lin_frame(text) for text in arguments.frames]
    for option, least in (("count", 1), ("timeout", 0)):
        if not getattr(arguments, option) >= least:
            raise BadValue(f"--{option} {getattr(arguments, option)}: {least} or more")
    with ExitStack() as closing:
        hub = connected(arguments, "lin send", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        monitor = opened_monitor(hub, place, closing, events=True)
        control = become_master(hub, place, arguments.bit_rate, closing)
        sending = Sending(
            control, monitor, place, Shown(hub, monitor, arguments.line, None), arguments.timeout
        )
        return max([sending.send(frame) for _ in range(arguments.count) for frame in frames])


class Sending:
    """Sends one frame after the other; a monitor reports the result of each."""

    def __init__(
        self, control: LinControl, monitor: Monitor, place: LinePlace, shown: Shown, timeout_s: float
    ) -> None:
        self._control = control
        self._monitor = monitor
        self._place = place
        self._shown = shown
        self._timeout_s = timeout_s

    def send(self, frame: LinFrame) -> int:
        """0 once it was seen; the answer to a header is shown. 1 with a line that says why not."""
        end_s = time.monotonic() + self._timeout_s
        why = self._put(frame, end_s) or self._seen(frame, end_s)
        if why:
            complain(f"{self._place.address}: {format_lin_frame(frame)} not delivered: {why}")
        return int(bool(why))

    def _put(self, frame: LinFrame, end_s: float) -> str:
        """Wait for what is on the wire; "" once the frame is on its way."""
        while self._monitor.receive() is not None:
            pass  # older news
        while True:
            try:
                self._control.send(frame)
            except Busy:
                if time.monotonic() >= end_s:
                    return "the line is busy all the time"
                time.sleep(_LOOK_S)
            else:
                return ""

    def _seen(self, frame: LinFrame, end_s: float) -> str:
        """ "" once the frame went over the bus, or why it did not."""
        while (message := self._monitor.receive(max(0.0, end_s - time.monotonic()))) is not None:
            if isinstance(message, LinFrame):
                if message.id == frame.id:
                    if frame.header_only:
                        self._shown.show(message)
                    return ""
            elif message.kind is LinEventKind.ERROR and message.id in (frame.id, -1):
                return _why(message.error, self._place)
        return f"nothing was heard in {self._timeout_s:g} s"


def _why(error: LinErrorKind, place: LinePlace) -> str:
    if error is LinErrorKind.SLNORE:
        return f"nobody answers on {place.info.bus or 'no bus'}"
    if error is LinErrorKind.NOBUS:
        return f"{place.info.bus or 'the line'} does not take its levels; is it shorted?"
    return f"error {error.name}"
