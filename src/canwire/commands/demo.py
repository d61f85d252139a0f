"""`canwire demo`: five nodes keep a machine cool, and one of them fails.

canwire demo                 30 s of it in virtual time, with the story and the numbers at the end
canwire demo --time real     the same at the speed of the wall clock

Sensors report, a controller switches fans. At 12 s the transceiver of fan 2
breaks: it drives the bus but reads its own frames wrong, so its error counter climbs until it is
bus-off. At 20 s it is repaired and restarted; after 128 times 11 recessive bits it is back.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from canwire import Acceptance, BadValue, Frame, Lab, LabBus, LogLine, NodeScript, format_candump_line
from canwire.commands.lab.fan_network import (
    STATUS,
    CodedIds,
    Coding,
    Controller,
    Fan,
    Machine,
    PlainIds,
    Sensor,
)
from canwire.commands.lab.summary import Summary
from canwire.commands.shell.parser import add_time_argument

_BIT_RATE = 125_000
_BREAKS_NS, _REPAIRED_NS = 12_000_000_000, 20_000_000_000
_BROKEN_BIT = 25  # in the data of fan 2's status frame
_SECOND_NS = 1_000_000_000
_COMMENT_COLUMN = 52


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("--seconds", type=float, default=30.0, metavar="N", help="of bus time (30)")
    add_time_argument(parser, ("virtual", "real"), "a private bus is virtual, or follows the clock")
    parser.add_argument(
        "--coded-ids", action="store_true", help="the manual's other proposal: values in the identifiers"
    )
    parser.add_argument("--json", action="store_true", help="print summary and story as one JSON object")


def run(arguments: argparse.Namespace) -> int:
    """Run the story and print it as it happens; BadValue for a time that runs backwards."""
    if not 0 < arguments.seconds <= 1e9:
        raise BadValue(f"--seconds {arguments.seconds:g}: more than 0, up to 1e9")
    demo = Demo(
        arguments.time or "virtual", CodedIds() if arguments.coded_ids else PlainIds(), quiet=arguments.json
    )
    summary = demo.run(arguments.seconds)
    if arguments.json:
        print(json.dumps({**summary.facts(), "story": demo.story}, indent=2))
    else:
        print("", *summary.lines(), sep="\n")
    return 0


class Demo:
    """The network, its story, and the trace of both. `story` contains what `tell` was called with, and its time."""

    def __init__(self, time: str, coding: Coding, *, quiet: bool) -> None:
        self.story: list[dict[str, Any]] = []
        self._time = time
        self._coding = coding
        self._quiet = quiet

    def run(self, seconds: float) -> Summary:
        """Run the network for this many seconds of bus time; returns the summary."""
        started_ns = time.monotonic_ns()
        with Lab(time=self._time) as lab:
            bus = lab.can_bus("can0", bit_rate=_BIT_RATE)
            monitor = Monitor(self._show)
            self._build(lab, bus, monitor)
            lab.at(_BREAKS_NS, partial(self._break, lab, bus))
            lab.at(_REPAIRED_NS, partial(self._repair, lab, bus))
            lab.run_until(round(seconds * _SECOND_NS))
            return Summary.of(
                bus,
                frames=monitor.frames,
                lost=sum(node.lost for node in bus.nodes.values()),
                bus_time_ns=lab.now_ns,
                wall_time_ns=time.monotonic_ns() - started_ns,
            )

    def _build(self, lab: Lab, bus: LabBus, monitor: Monitor) -> None:
        machine, coding = Machine(), self._coding
        tell = partial(self._tell, lab)
        bus.node("monitor", monitor, listen_only=True)
        reports = coding.temperatures()
        statuses = Acceptance.from_filters([(STATUS + 1, 0x7FF), (STATUS + 2, 0x7FF)])
        bus.node("controller", Controller(coding, (1, 2), tell), filters=reports | statuses)
        for number in (1, 2):
            bus.node(f"sensor {number}", Sensor(machine, coding, number), filters=[])
            bus.node(f"fan {number}", Fan(machine, coding, number, tell), filters=coding.switches(number))

    def _break(self, lab: Lab, bus: LabBus) -> None:
        self._tell(lab, "the transceiver of fan 2 breaks: fan 2 reads its own frames wrong")
        bus.faults.flip(frame_id=STATUS + 2, bit=_BROKEN_BIT, times=None, seen_by="sender")

    def _repair(self, lab: Lab, bus: LabBus) -> None:
        self._tell(lab, "fan 2 is repaired and restarted: it waits for 128 times 11 recessive bits")
        bus.faults.clear()
        bus.nodes["fan 2"].restart()

    def _tell(self, lab: Lab, what: str) -> None:
        at_ns = lab.now_ns
        self.story.append({"time_ns": at_ns, "what": what})
        self._print(f" ({at_ns // _SECOND_NS:010d}.{at_ns // 1000 % 1_000_000:06d})  -- {what}")

    def _show(self, frame: Frame) -> None:
        line = format_candump_line(LogLine(frame.timestamp_ns, "can0", frame), timestamp=True)
        self._print(f"{line:<{_COMMENT_COLUMN}}; {meaning(self._coding, frame)}")

    def _print(self, text: str) -> None:
        if not self._quiet:
            print(text, flush=self._time == "real")


class Monitor(NodeScript):
    """Counts and shows every frame."""

    def __init__(self, show: Callable[[Frame], None]) -> None:
        self.frames = 0
        self._show = show

    def on_message(self, frame: Frame) -> None:
        self.frames += 1
        self._show(frame)


def meaning(coding: Coding, frame: Frame) -> str:
    """The text for a frame of the demo: its sender and the content."""
    reading = coding.read_temperature(frame)
    if reading is not None:
        return f"sensor {reading[0]}: {reading[1]} degrees"
    command = coding.read_switch(frame)
    if command is not None:
        return f"controller: fan {command[0]} {'on' if command[1] else 'off'}"
    return f"fan {frame.id - STATUS}: {'turning' if frame.data[0] else 'standing'}"
