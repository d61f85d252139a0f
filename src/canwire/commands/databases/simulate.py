"""`canwire simulate`: send the messages of a node of a network description, at their cycle times.

canwire simulate Engine can0 --db examples/engine.dbc                 until Ctrl-C, with or without a receiver
canwire simulate Engine can0 --db examples/engine.dbc --duration 0.2 --set EngineSpeed=1500 --set EngineData.Ready=yes
canwire simulate Engine can0 --db examples/engine.dbc --duration 0.2 --plugin examples.alive:alive

Signals start with the values of --set, else with the start values of the file (GenSigStartValue). A plug-in is a
function that is called with each message before it is sent, for counters and checksums; docs/how-to/databases.md
contains an example. At the end, also after Ctrl-C, a line on stderr gives the number of frames sent of each message and
the number of frames delivered. The exit status is 1 if frames were not delivered.
"""

from __future__ import annotations

import argparse
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, Frame, HubError, Simulation
from canwire.commands.can_line import add_line_arguments, add_timeout_argument, open_sender, wanted_by
from canwire.commands.console import complain
from canwire.commands.databases.chosen import database_of
from canwire.commands.databases.plugins import find_plugin
from canwire.commands.databases.words import Value, add_database_arguments, add_plugin_argument, split
from canwire.commands.send import Sending
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub, HubChannel

_QUEUE = 1024
_NS = 1_000_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("node", metavar="NODE", help="the node of the description whose messages are sent")
    add_line_arguments(parser)
    add_database_arguments(parser, "the messages of the node")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="SIGNAL=VALUE",
        help="start value of a signal; Message.Signal=VALUE for one message only",
    )
    add_plugin_argument(parser, "a function that finishes each message before it is sent")
    parser.add_argument("--duration", type=float, metavar="SECONDS", help="end after this time")
    add_timeout_argument(parser, "at the end, ")


def run(arguments: argparse.Namespace) -> int:
    """Send until the end; 1 if frames were not delivered. BadValue, BadDescription, NoSuchBoard, HubError otherwise."""
    simulation = simulated(arguments)
    with ExitStack() as closing:
        hub = connected(arguments, "simulate", closing)
        place, channel = open_sender(hub, arguments.line, wanted_by(arguments), _QUEUE, closing)
        complain(f"{place.address} on {place.info.bus}: {_told(simulation)}")
        running = Running(hub, channel, simulation, Sending(hub, place, channel, arguments.timeout))
        try:
            running.run(arguments.duration)
            return running.sending.result()
        finally:
            complain(running.summary())


def simulated(arguments: argparse.Namespace) -> Simulation:
    """The node with its values and plug-ins; raises BadValue, BadDescription."""
    database = database_of(arguments)
    if database is None:
        raise BadValue("simulate needs a description of the network: --db FILE")
    if arguments.duration is not None and not arguments.duration >= 0:
        raise BadValue(f"--duration {arguments.duration}: 0 or more")
    values: dict[str, Value] = {}
    for word in arguments.set:
        name, text = split(word)
        signals = [m.signals for m in database.sent_by(arguments.node)]
        told = next(
            (each[name.rpartition(".")[2]] for each in signals if name.rpartition(".")[2] in each), None
        )
        values[name] = text if told is None else told.parse(text)
    plugins = [find_plugin(text) for text in arguments.plugin]
    return database.simulated(
        arguments.node,
        signals=values,
        plugins=plugins,
        fill=arguments.fill if arguments.fill is not None else 0,
    )


class Running:
    """A simulation on a shared line, in the hub's time."""

    def __init__(self, hub: Hub, channel: HubChannel, simulation: Simulation, sending: Sending) -> None:
        self._hub = hub
        self._channel = channel
        self._simulation = simulation
        self.sending = sending
        self._refused = 0

    def run(self, duration_s: float | None) -> None:
        """Send until the time is over, or without end. If no node acknowledges, cycles without room are left out."""
        end_ns = None if duration_s is None else self._now_ns() + round(duration_s * _NS)
        while end_ns is None or self._now_ns() < end_ns:
            for frame in self._simulation.due(self._now_ns()):
                assert isinstance(frame, Frame)  # LIN messages have no cycle times
                if not self.sending.offer(frame):
                    self._refused += 1
            until_ns = self._simulation.next_ns()
            self._wait_until(until_ns if end_ns is None else min(until_ns, end_ns))

    def summary(self) -> str:
        """What was sent, and what became of it."""
        simulation = self._simulation
        text = f"{simulation.node}: {simulation.summary()}; {simulation.sent.total() - self._refused} sent"
        try:
            text += f", {self._channel.status().delivered} delivered"
        except HubError as error:
            text += f", delivered unknown: {error}"
        if self._refused:
            text += f", {self._refused} left out while the bus took none"
        return text + f", {simulation.missed} cycles missed"

    def _now_ns(self) -> int:
        return self._hub.now_ns() if self._hub.virtual else time.monotonic_ns()

    def _wait_until(self, time_ns: int) -> None:
        left_s = max(0, time_ns - self._now_ns()) / _NS
        if self._hub.virtual:
            self._hub.run_for(left_s)
        else:
            time.sleep(left_s)


def _told(simulation: Simulation) -> str:
    periods = ", ".join(
        f"{message.name} every {(message.cycle_s or 0) * 1000:g} ms" for message in simulation.messages
    )
    left_out = simulation.without_cycle
    return f"{simulation.node} sends {periods}" + (
        f"; without a cycle time: {', '.join(left_out)}" if left_out else ""
    )
