"""`canwire send`: send frames from a line and wait until they are delivered.

canwire send can0 123#1122                    from the first line on can0 that no program uses
canwire send HW000001:0 123#1122 12345678#R   from this line, even if other programs use it
canwire send can0 '123##1AABB' -n 10 --gap 0.1
canwire send can0 EngineData EngineSpeed=1500 Ready=yes --db examples/engine.dbc     by name
canwire send can0 EngineData -n 3 --db examples/engine.dbc --plugin examples.alive:alive

With --db, FRAME is a message name followed by signal values: physical values, or the texts that the file defines for
them. Omitted signals get the file's start values. E2E counters and checksums that the file describes are filled in, and
--plugin completes messages as in `canwire simulate`. With -n, counters continue from frame to frame.

Exit status 1 if frames were not delivered. A frame is delivered when another controller has acknowledged it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import (
    BadValue,
    ChannelStatus,
    ErrorKind,
    ErrorState,
    Frame,
    LinePlace,
    LineStatus,
    QueueFull,
)
from canwire.commands.can_line import add_line_arguments, add_timeout_argument, open_sender, wanted_by
from canwire.commands.console import complain
from canwire.commands.databases.chosen import database_of
from canwire.commands.databases.words import add_database_arguments, add_plugin_argument, numbered_frames_of
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub, HubChannel
    from canwire.commands.databases.plugins import Plugin

_QUEUE = 256
_LOOK_S = 0.002  # between two looks at what is still waiting
_TRIES = 100  # to take back a frame that is repeated without end, and so nearly always on the wire


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_arguments(parser)
    add_database_arguments(parser, "messages are sent by name")
    add_plugin_argument(parser, "finishes each message of --db: counters, checksums")
    parser.add_argument(
        "frames", nargs="+", metavar="FRAME", help="123#1122, 12345678#R, 123##1AABB; MESSAGE SIGNAL=VALUE"
    )
    parser.add_argument(
        "-n", "--count", type=int, default=1, metavar="COUNT", help="send the whole list COUNT times (1)"
    )
    parser.add_argument("--gap", type=float, default=0.0, metavar="SECONDS", help="time between two frames")
    add_timeout_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Send; 1 if frames were not delivered. BadText for no frame; BadValue, BadDescription, NoSuchBoard, HubError."""
    database = database_of(arguments)
    if arguments.plugin and database is None:
        raise BadValue(f"--plugin {arguments.plugin[0]}: it finishes messages of --db FILE")
    frames = numbered_frames_of(arguments.frames, database, arguments.fill, _plugins(arguments.plugin))
    for name, least in (("count", 1), ("gap", 0), ("timeout", 0)):
        if not getattr(arguments, name) >= least:
            raise BadValue(f"--{name} {getattr(arguments, name)}: {least} or more")
    with ExitStack() as closing:
        hub = connected(arguments, "send", closing)
        place, channel = open_sender(hub, arguments.line, wanted_by(arguments), _QUEUE, closing)
        sending = Sending(hub, place, channel, arguments.timeout)
        sending.send(frames, arguments.count, arguments.gap)
        return sending.result()


def _plugins(words: list[str]) -> list[Plugin]:
    """Return the plugins with these names; without words, nothing is loaded. Raises BadValue."""
    if not words:
        return []
    from canwire.commands.databases.plugins import find_plugin

    return [find_plugin(text) for text in words]


class Sending:
    """Sends frames by one channel; `timeout_s` is the longest time without progress, in seconds."""

    def __init__(self, hub: Hub, place: LinePlace, channel: HubChannel, timeout_s: float) -> None:
        self._hub = hub
        self._place = place
        self._channel = channel
        self._timeout_s = timeout_s
        self._total = 0
        self._told = False

    def send(self, frames: Sequence[Frame | Callable[[int], Frame]], count: int, gap_s: float) -> None:
        """Queue all frames `count` times, `gap_s` apart; a function gets its round. Stop if the queue stays full."""
        total = count * len(frames)
        due_s = time.monotonic()
        for number in range(total):
            if number and gap_s:
                due_s += gap_s
                self._pause(gap_s if self._hub.virtual else max(0.0, due_s - time.monotonic()))
            turn, place = divmod(number, len(frames))
            found = frames[place]
            if not self.queue(found if isinstance(found, Frame) else found(turn)):
                self._total = total
                return

    def queue(self, frame: Frame) -> bool:
        """Queue a frame; wait for room in the queue if it is full. False if there was no room in time."""
        self._total += 1
        try:
            self._channel.send(frame, timeout=self._timeout_s)
        except QueueFull:
            return False
        return True

    def offer(self, frame: Frame) -> bool:
        """Queue a frame if there is room now; if not, return False and say once why the bus takes no frames."""
        try:
            self._channel.send(frame)
        except QueueFull:
            self.tell_of_waiting()
            return False
        self._total += 1
        return True

    def queue_patiently(self, frame: Frame, end: Callable[[], bool]) -> bool:
        """Queue a frame and wait for room without limit; False if `end()` is true or the line no longer runs."""
        self._total += 1
        while not end():
            try:
                self._channel.send(frame, timeout=self._timeout_s)
            except QueueFull:
                if not self._place.status(self._hub).running:
                    return False
                self.tell_of_waiting()
            else:
                return True
        self._total -= 1
        return False

    def tell_of_waiting(self) -> None:
        """Say why the bus takes no frames; only the first call prints."""
        if not self._told:
            self._told = True
            why = self._why(self._channel.status(), self._place.status(self._hub))
            complain(f"{self._place.address}: the bus takes no frames: {why}; waiting, Ctrl-C ends it")

    @property
    def delivered(self) -> int:
        """The number of frames that the bus has carried so far."""
        return self._channel.status().delivered

    def result(self) -> int:
        """Wait until the bus has carried the frames; else say how many are missing and why, and discard them."""
        status = self._settled()
        if status.delivered < self._total:
            why = self._why(status, self._place.status(self._hub))
            missing = self._total - self.give_up().delivered
            if missing:
                complain(f"{self._place.address}: {missing} of {self._total} frames not delivered: {why}")
                return 1
        return 0

    def _settled(self) -> ChannelStatus:
        status = self._channel.status()
        while status.pending and self._changes(status.pending):
            status = self._channel.status()
        return status

    def _changes(self, pending: int) -> bool:
        """Wait until the number of pending frames changes; False if `timeout_s` is over before."""

        def changed() -> bool:
            return self._channel.status().pending != pending

        if self._hub.virtual:
            return self._hub.advance(changed, self._timeout_s)
        end_s = time.monotonic() + self._timeout_s
        while not changed():
            if time.monotonic() >= end_s:
                return False
            time.sleep(_LOOK_S)
        return True

    def give_up(self) -> ChannelStatus:
        """Discard all waiting frames; retry after a frame on the wire, which cannot be discarded."""
        for _ in range(_TRIES):
            self._channel.cancel()
            status = self._channel.status()
            if not status.pending:
                break
            self._pause(_LOOK_S)
        return status

    def _pause(self, seconds: float) -> None:
        if self._hub.virtual:
            self._hub.run_for(seconds)
        else:
            time.sleep(seconds)

    def _why(self, channel: ChannelStatus, line: LineStatus) -> str:
        if channel.refused:
            return f"the line cannot send them, it is set up for {format_text(line)}"
        if channel.aborted:
            return "they were given up when the line was stopped or reset"
        if not line.running:
            return f"the line does not run; its control is held by {line.control_holder or 'nobody'}"
        if line.mode is not None and line.mode.listen_only:
            return "the line only listens"
        if line.obstacle:
            return line.obstacle
        if line.coupling_fault:
            return f"{self._place.info.bus} is shorted"
        if line.state == ErrorState.BUS_OFF:
            return "bus-off"
        where = f"{ErrorState(line.state).name.lower().replace('_', ' ')}, TEC {line.tec}"
        if line.last_error == ErrorKind.ACK:
            return f"nobody acknowledges; no other controller runs on {self._place.info.bus} ({where})"
        return f"no progress in {self._timeout_s:g} s ({where})"


def format_text(line: LineStatus) -> str:
    """Return text that says which frames a line can send."""
    mode = line.mode
    if mode is None:
        return "nothing"
    formats = [name for name, there in (("11-bit", mode.standard), ("29-bit", mode.extended)) if there]
    kind = "classic CAN"
    if mode.long_data or mode.data_timing is not None:
        kind = "CAN FD" + ("" if mode.long_data else " of up to 8 bytes")
        kind += "" if mode.data_timing is not None else " without BRS"
    return f"{kind} with {' and '.join(formats)} identifiers"
