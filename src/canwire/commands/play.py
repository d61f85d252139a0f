"""`canwire play`: send the frames of a log, in any format, on a bus at their times.

canwire play drive.log can0                        onto a shared line: every node on can0 receives it
canwire play drive.blf can0 --speed 10             ten times as fast; 0: as fast as the bus takes them
canwire play drive.log --map can0=can1,can1=can0   the log's can0 onto the line can1, its can1 onto can0
canwire play drive.log can0 --loop 3               three times; --loop alone: until Ctrl-C; -s 2: no longer pauses
canwire play drive.log can0 --filter 100:700       frames 100 to 1FF only
canwire play drive.log                             onto a private bus, as fast as possible, with a summary at the end
canwire play drive.log --time real                 the same at the speed of the wall clock
canwire play drive.log --log rx.log --vcd out.vcd  what a node on that bus received, and the level of the wire

A frame is due at its time stamp, counted from the log's first; the bus then decides when it goes. LINE=CHANNEL plays
one channel of the log onto a line, as canplayer has it: `can1=can0` is --map can0=can1.
A separate node sends each identifier, as in a car, so frames that are due together arbitrate; beyond 256 identifiers
they take turns at up to 64 nodes. With --vcd, which examines every bit of every node, one node sends all frames unless
--senders each is given.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import time
from collections.abc import Callable
from contextlib import ExitStack

from canwire import BadValue, Frame, Lab, LabBus, LogLine, QueueFull, format_log_line
from canwire.commands.console import complain
from canwire.commands.dump.filters import Capture, parse_capture
from canwire.commands.lab.any_log import AnyLog, log_to_play
from canwire.commands.lab.candump_log import CandumpLog, Complaints, Survey
from canwire.commands.lab.output import Output, opened
from canwire.commands.lab.senders import Senders
from canwire.commands.lab.summary import Summary, line
from canwire.commands.lab.trace_cost import forecast
from canwire.commands.logs.choosing import add_filter_argument, add_map_argument
from canwire.commands.shared_hub import add_hub_argument
from canwire.commands.shell.ending import is_full
from canwire.commands.shell.parser import add_time_argument
from canwire.commands.shell.progress import Progress

_IN_FLIGHT = 8192  # frames sent and not yet recorded: they always fit into the recorder's queue
_STEP_S = 0.001  # how long a full queue is given before it is looked at again
_SHARED_ONLY = ("hub", "speed", "timeout", "loop", "gap", "skip", "verbose")
_PRIVATE_ONLY = ("bus", "time", "log_out", "vcd", "senders")
_PRIVATE_DEFAULTS = {"bus": "can0", "time": "virtual", "bit_rate": 500_000}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "log", metavar="LOG", help="a log of any format; - is a candump log on standard input"
    )
    parser.add_argument(
        "line",
        nargs="*",
        metavar="LINE",
        help="a line that programs share: can0, HW000001:0, or for one channel can1=can0; left out, --bus",
    )
    add_filter_argument(parser)
    parser.add_argument("--bit-rate", type=int, metavar="BIT/S", help="default: 500000, or what LINE runs at")
    parser.add_argument(
        "--data-bit-rate", type=int, metavar="BIT/S", help="a log with CAN FD frames needs it"
    )
    parser.add_argument("--strict", action="store_true", help="exit status 1 if the log has broken lines")
    parser.add_argument("--json", action="store_true", help="print the summary as one JSON object")
    shared = parser.add_argument_group("onto a shared LINE")
    add_map_argument(shared, "the line that a channel of the log goes onto; again, or with commas: several")
    shared.add_argument("--speed", type=float, metavar="FACTOR", help="default: 1; 0: as fast as it goes")
    shared.add_argument(
        "-t", dest="speed", action="store_const", const=0.0, help="without the log's times: --speed 0"
    )
    shared.add_argument("-g", "--gap", type=float, metavar="MS", help="a pause after every frame, with -t")
    shared.add_argument(
        "-s", "--skip", type=float, metavar="SECONDS", help="leave out pauses that are longer than this"
    )
    shared.add_argument(
        "-v", "--verbose", action="store_true", default=None, help="print each frame as it is sent"
    )
    shared.add_argument(
        "-l",
        "--loop",
        nargs="?",
        type=_rounds,
        const=0,
        metavar="N",
        help="play N times; without N, or with i: endlessly",
    )
    shared.add_argument(
        "--timeout",
        type=float,
        metavar="SECONDS",
        help="give up when nothing has been delivered for this long (1)",
    )
    add_hub_argument(shared)
    private = parser.add_argument_group("onto a private bus, which no other program hears")
    private.add_argument("--bus", metavar="NAME", help="what the bus is called in logs (can0)")
    add_time_argument(private, ("virtual", "real"), "a private bus is virtual, or follows the clock")
    private.add_argument("--log", dest="log_out", metavar="OUT", help="write what arrives to this log")
    private.add_argument(
        "--vcd",
        metavar="OUT",
        help="write the level of the wire, bit by bit; says beforehand how long that takes",
    )
    private.add_argument(
        "--senders",
        choices=("each", "one"),
        help="a separate node for each identifier (default), or one node sends them all (default with --vcd)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Play the log; raises BadValue for a log that this bus cannot carry and for files that do not open."""
    try:
        return _run(arguments)
    except BrokenPipeError:
        raise  # the reader of our output has gone: no mistake of the user's
    except OSError as error:
        if is_full(error):
            raise
        raise BadValue(f"{error.filename or arguments.log}: {error.strerror}") from error


def _run(arguments: argparse.Namespace) -> int:
    wanted = wanted_by(parse_capture(arguments.filter, (), False))
    if not arguments.line and not arguments.map:
        _refuse_others(
            arguments, _SHARED_ONLY, "that is for a shared line; name one behind the log, can0 perhaps"
        )
        usual_senders = "each" if arguments.vcd is None else "one"
        for name, usual in {**_PRIVATE_DEFAULTS, "senders": usual_senders}.items():
            if getattr(arguments, name) is None:
                setattr(arguments, name, usual)
        return _play_privately(arguments, wanted)
    from canwire.commands.lab.shared_play import play_shared

    lines = " ".join([*arguments.line, *arguments.map])
    _refuse_others(arguments, _PRIVATE_ONLY, f"that is for a private bus; leave {lines} or it out")
    with log_to_play(arguments.log, wanted) as log:
        found = log.survey(Complaints(arguments.log))
        return play_shared(arguments, log, found)


def _rounds(text: str) -> int:
    """Return how many times the log is played; 0 is without end, for "i" as in canplayer."""
    return 0 if text == "i" else int(text)


def wanted_by(capture: Capture) -> Callable[[Frame], bool] | None:
    """Return a function that says whether a frame is to be played; None if all are."""
    return capture.accepts if capture.filters else None


def _refuse_others(arguments: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    for name in names:
        if getattr(arguments, name) is not None:
            option = "--log" if name == "log_out" else f"--{name}"
            raise BadValue(f"{option}: {why}")


def _play_privately(arguments: argparse.Namespace, wanted: Callable[[Frame], bool] | None) -> int:
    _check_names(arguments)
    with log_to_play(arguments.log, wanted) as log:
        found = log.survey(Complaints(arguments.log))
        if found.fd_line is not None and arguments.data_bit_rate is None:
            raise BadValue(
                f"{arguments.log}:{found.fd_line}: a CAN FD frame; add --data-bit-rate, 2000000 perhaps"
            )
        if arguments.vcd is not None:
            cost = forecast(found.bits, len(found.keys), one=arguments.senders == "one")
            if cost:
                complain(cost)
        with ExitStack() as closing:
            player = Player(arguments, found, closing)
            if not arguments.json:
                print(
                    line(
                        "private bus",
                        f"{arguments.bus}, heard by no other program; `play LOG LINE` uses a shared one",
                    )
                )
            player.play(log)
            summary = player.summary()
    skipped = {
        "broken_lines": found.broken_lines,
        "error_frames_skipped": found.error_frames,
        "stamps_going_back": player.going_back,
    }
    if arguments.json:
        print(json.dumps({**summary.facts(), **skipped}, indent=2))
    else:
        print(*summary.lines(), *_skipped_lines(skipped), sep="\n")
    return 1 if arguments.strict and found.broken_lines else 0


class Player:
    """Plays a log on a bus that has the log's senders and a recorder."""

    def __init__(self, arguments: argparse.Namespace, found: Survey, closing: ExitStack) -> None:
        self.going_back = 0
        self._started_ns = time.monotonic_ns()
        self._lab = closing.enter_context(Lab(time=arguments.time))
        self._bus = self._lab.can_bus(
            arguments.bus, bit_rate=arguments.bit_rate, data_bit_rate=arguments.data_bit_rate
        )
        self._recorder = self._bus.node("recorder", receive_queue=_IN_FLIGHT, transmit_queue=1)
        self._send_by = _sender(self._bus, found, arguments.senders)
        if arguments.vcd is not None:
            self._bus.trace_levels(arguments.vcd)
        self._out: Output | None = None
        if arguments.log_out is not None:
            self._out = closing.enter_context(opened(arguments.log_out))
        self._progress = closing.enter_context(Progress(found.lines, "playing"))
        self._first_ns = found.first_ns
        self._zero_ns = self._lab.now_ns  # real time has begun to run already
        self._sent = 0
        self._recorded = 0

    def play(self, log: CandumpLog | AnyLog) -> None:
        """Play every frame of the log, then run until the bus is idle."""
        due_ns = 0
        for number, frame, _ in log.frames():
            stamp_ns = frame.timestamp_ns - self._first_ns
            if stamp_ns < due_ns:
                self.going_back += 1
            elif stamp_ns > due_ns:
                due_ns = stamp_ns
                self._run_until(self._zero_ns + due_ns)
                self._progress.show(number)
            self._send(frame)
        self._lab.run_until_idle()
        self._record()

    def summary(self) -> Summary:
        """Return the numbers so far."""
        return Summary.of(
            self._bus,
            frames=self._recorded,
            lost=self._recorder.lost,
            bus_time_ns=self._lab.now_ns - self._zero_ns,
            wall_time_ns=time.monotonic_ns() - self._started_ns,
        )

    def _send(self, frame: Frame) -> None:
        """Queue the frame; while a queue is full, let time pass on the bus and try again."""
        while True:
            try:
                if self._sent - self._recorded < _IN_FLIGHT:
                    self._send_by(frame)
                    self._sent += 1
                    return
            except QueueFull:
                pass
            self._run_until(self._lab.now_ns + round(_STEP_S * 1e9))

    def _run_until(self, time_ns: int) -> None:
        self._lab.run_until(time_ns)
        self._record()

    def _record(self) -> None:
        """Count the frames in the recorder's queue and write them to the output log."""
        frames = self._recorder.receive_many(_IN_FLIGHT)
        self._recorded += len(frames)
        if self._out is not None:
            zero_ns = self._first_ns - self._zero_ns
            for frame in frames:
                self._out.write(format_log_line(LogLine(zero_ns + frame.timestamp_ns, self._bus.name, frame)))
                self._out.write("\n")


def _sender(bus: LabBus, found: Survey, senders: str) -> Callable[[Frame], None]:
    """Return a function that queues a frame, or raises QueueFull."""
    if senders == "each":
        return Senders(bus, found.keys).send
    node = bus.node("player", receives=False, receive_queue=1, transmit_queue=_IN_FLIGHT)
    return lambda frame: node.send(frame)


def _check_names(arguments: argparse.Namespace) -> None:
    """Raise BadValue if the bus's name does not fit into a log, or if one file is given twice."""
    if not re.fullmatch(r"[^\s()]+", arguments.bus):
        raise BadValue(f"--bus {arguments.bus!r}: a name without blanks and parentheses")
    taken: dict[str, str] = {}
    for path in (arguments.log, arguments.log_out, arguments.vcd):
        if path is None or path == os.devnull:
            continue
        if taken.setdefault(os.path.realpath(path), path) is not path:
            raise BadValue(f"{path}: the same file twice; give each its own name")


def _skipped_lines(skipped: dict[str, int]) -> list[str]:
    """Return a line with a count for each reason why lines were not played as the log contains them."""
    notes = {
        "broken_lines": ("skipped", "broken lines"),
        "error_frames_skipped": ("skipped", "error frames of the log"),
        "stamps_going_back": ("sent without waiting", "frames with a time stamp before an earlier line's"),
    }
    return [line(notes[name][0], f"{count} {notes[name][1]}") for name, count in skipped.items() if count]
