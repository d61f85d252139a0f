"""`canwire lin`: watch a LIN line, send from one as its master, run a schedule.

canwire lin dump lin0                         the first line on that bus; started as slave if nobody did
canwire lin dump HW000001:2 -e --ldf door.ldf errors and changes of state, too; what signals say
canwire lin send lin0 10#0102 11#R4           as master: a frame, then a header for somebody to answer
canwire lin schedule lin0 10#0102 11:4@10ms   slot after slot, while it runs; 11 is asked for 4 bytes
canwire lin schedule lin0 --ldf door.ldf --table Normal --rounds 10

Everything is shown as log lines: T behind what the line itself sent, R behind what it received. Sending takes the
line's control: one at a time. Exit status of `send`: 1 if something was not seen on the bus.
"""

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
from canwire.commands.console import complain, let_terminate
from canwire.commands.lin.line import (
    Wish,
    add_lin_arguments,
    become_master,
    begin_listening,
    end_schedule,
    find_lin_line,
    lin_status_of,
)
from canwire.commands.lin.show import Shown, loaded_network, opened_monitor
from canwire.commands.lin.slots import described, parsed, with_delays
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub, LinControl, Monitor

_LOOK_S = 0.002  # between two looks whether the line is free
_ROUND_S = 0.05  # between two looks whether a schedule is over


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    verbs = parser.add_subparsers(metavar="verb", required=True)
    for name, help, add, verb in (
        ("dump", "show what happens on a line", _add_dump_arguments, _dump),
        ("send", "send frames as master", _add_send_arguments, _send),
        ("schedule", "run a schedule as master", _add_schedule_arguments, _schedule),
    ):
        sub = verbs.add_parser(name, help=help, description=help)
        add_lin_arguments(sub)
        add(sub)
        sub.set_defaults(lin_verb=verb)


def run(arguments: argparse.Namespace) -> int:
    """The sub-verb; HubError without a hub, NoSuchBoard, BadValue, BadText, InUse for what cannot be."""
    return int(arguments.lin_verb(arguments))


# dump


def _add_dump_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--master", action="store_true", help="start a line that nobody started as master, not as slave"
    )
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after so many lines")
    parser.add_argument("-T", "--timeout", type=float, metavar="SECONDS", help="end after so much silence")
    parser.add_argument("-e", "--errors", action="store_true", help="show errors and changes of state, too")
    parser.add_argument("-i", "--bus-name", action="store_true", help="show the bus's name instead of LINE")
    parser.add_argument("--ldf", metavar="FILE", help="show the signals, as this description has them")


def _dump(arguments: argparse.Namespace) -> int:
    """Print lines until COUNT, silence or Ctrl-C."""
    for option, least in (("count", 1), ("timeout", 0)):
        value = getattr(arguments, option)
        if value is not None and not value >= least:
            raise BadValue(f"--{option} {value}: {least} or more")
    network = loaded_network(arguments.ldf)
    with ExitStack() as closing:
        let_terminate(closing)
        hub = connected(arguments, "lin dump", closing)
        place = find_lin_line(hub, arguments.line)
        monitor = opened_monitor(hub, place, closing, events=arguments.errors)
        rate = arguments.bit_rate
        if rate is None and network is not None and not lin_status_of(hub, place).running:
            rate = network.bit_rate
        told = begin_listening(hub, place, Wish(arguments.master, rate))
        name = place.info.bus if arguments.bus_name and place.info.bus else arguments.line
        shown = Shown(hub, monitor, name, network)
        try:
            complain(told)
            while arguments.count is None or shown.lines < arguments.count:
                message = monitor.receive(arguments.timeout)
                if message is None:
                    break
                shown.show(message)
        finally:
            complain(shown.summary())
    return 0


# send


def _add_send_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "frames", nargs="+", metavar="FRAME", help="10#0102, 10#0102_C; a header: 10#R, 10#R4"
    )
    parser.add_argument(
        "-n", "--count", type=int, default=1, metavar="COUNT", help="send all of them so often"
    )
    parser.add_argument(
        "--timeout", type=float, default=1.0, metavar="SECONDS", help="give a frame up after so long (1)"
    )


def _send(arguments: argparse.Namespace) -> int:
    """Send; 1 if something was not seen on the bus."""
    frames = [parse_lin_frame(text) for text in arguments.frames]
    for option, least in (("count", 1), ("timeout", 0)):
        if not getattr(arguments, option) >= least:
            raise BadValue(f"--{option} {getattr(arguments, option)}: {least} or more")
    with ExitStack() as closing:
        let_terminate(closing)
        hub = connected(arguments, "lin send", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        monitor = opened_monitor(hub, place, closing, events=True)
        control = become_master(hub, place, arguments.bit_rate, closing)
        sending = Sending(
            control, monitor, place, Shown(hub, monitor, arguments.line, None), arguments.timeout
        )
        return max([sending.send(frame) for _ in range(arguments.count) for frame in frames])


class Sending:
    """One frame after the other; a monitor tells what became of each."""

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


# schedule


def _add_schedule_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "slots", nargs="*", metavar="SLOT", help="10, 11:4@10ms (bytes asked for, time to the next), 12#0102"
    )
    parser.add_argument(
        "--rounds", type=int, default=0, metavar="N", help="end after so many (default: Ctrl-C)"
    )
    parser.add_argument("--ldf", metavar="FILE", help="take a table and the master's frames from it instead")
    parser.add_argument("--table", metavar="NAME", help="which one of its schedules (default: the first)")


def _schedule(arguments: argparse.Namespace) -> int:
    """Run it in the hub, and print what comes, until its rounds are over or Ctrl-C."""
    if arguments.rounds < 0:
        raise BadValue(f"--rounds {arguments.rounds}: 1 or more, or 0 for ever")
    if bool(arguments.slots) == (arguments.ldf is not None):
        raise BadValue("give slots, or a description by --ldf")
    network = loaded_network(arguments.ldf)
    table, frames = described(network, arguments.table) if network else parsed(arguments.slots)
    with ExitStack() as closing:
        let_terminate(closing)
        hub = connected(arguments, "lin schedule", closing)
        place = find_lin_line(hub, arguments.line, to_send=True)
        monitor = opened_monitor(hub, place, closing, events=True)
        rate = arguments.bit_rate or (None if network is None else network.bit_rate)
        control = become_master(hub, place, rate, closing)
        closing.callback(end_schedule, control)
        table = with_delays(table, lin_status_of(hub, place).bit_rate)
        for frame in frames:
            control.respond(frame)
        control.run_schedule(table, arguments.rounds)
        span_ns = arguments.rounds * sum(slot.delay_ns for slot in table.slots)
        shown = Shown(hub, monitor, arguments.line, network)
        try:
            _follow(hub, shown, monitor, hub.now_ns() + span_ns if span_ns else None)
        finally:
            complain(shown.summary())
    return 0


def _follow(hub: Hub, shown: Shown, monitor: Monitor, end_ns: int | None) -> None:
    """Show what comes until that time of the hub's; None: for ever."""
    while True:
        message = monitor.receive(None if end_ns is None else _ROUND_S)
        if message is not None:
            shown.show(message)
        elif end_ns is not None and hub.now_ns() >= end_ns:
            return
