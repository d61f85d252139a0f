"""Sends a node's messages at their cycle times, with counters and checksums by functions of the user.

It contains no clock: its caller gets the frames of a moment from `due`. In a lab it is the script of a node.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from canwire.databases.codec import Codec
from canwire.databases.description import MessageDescription, Number, Value
from canwire.databases.near import near
from canwire.errors import BadValue, QueueFull
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

_NS = 1_000_000_000


class OutgoingMessage:
    """A message before it is sent, for plug-ins: they may change `signals`.

    `name` is the message's, `count` the number of them sent before, `signals` all its values by name. If a
    plug-in changes a multiplexer, signals of the new page that it does not set have their start values.
    """

    def __init__(self, codec: Codec, name: str, count: int, signals: dict[str, Value], fill: Number) -> None:
        self.name = name
        self.count = count
        self.signals = signals
        self._codec = codec
        self._fill = fill

    def encoded(self) -> bytes:
        """The data with the present signals, for a checksum."""
        return self.frame().data

    def frame(self) -> Frame | LinFrame:
        """The frame with the present signals; raises BadSignals."""
        there = self._codec.message(self.name).signals
        chosen = self._codec.signals_in(self.name, self.signals)
        kept = {name: value for name, value in self.signals.items() if name in chosen or name not in there}
        return self._codec.encode(self.name, kept, fill=self._fill)

    def __repr__(self) -> str:
        return f"<{self.name} number {self.count}: {self.signals}>"


class Simulation:
    """Node `node`: each of its messages that has a cycle time, beginning with the start values.

    `signals` replace start values, by "Signal" (in every message with it) or "Message.Signal". `plugins` are called
    with each message before it is sent; the file's E2E profiles are applied after them. `fill` is the value of signals
    without a start value in the file, limited to their range.
    `sent` counts by message, `missed` counts cycles that were too late to be sent, `refused` frames that found no room
    in the queue. `without_cycle` names messages that are not sent because the file gives them no cycle time.
    """

    def __init__(
        self,
        codec: Codec,
        node: str,
        *,
        signals: Mapping[str, Value] | None = None,
        plugins: Iterable[Callable[[OutgoingMessage], None]] = (),
        fill: Number = 0,
    ) -> None:
        own = codec.sent_by(node)
        self.node = node
        self.messages = [message for message in own if message.cycle_s]
        self.without_cycle = [message.name for message in own if not message.cycle_s]
        if not self.messages:
            names = ", ".join(self.without_cycle) or "none"
            raise BadValue(f"{codec.path}: {node} has no message with a cycle time (messages: {names})")
        self.sent: Counter[str] = Counter()
        self.missed = 0
        self.refused = 0
        self._codec = codec
        self._fill = fill
        self._plugins = tuple(plugins)
        self._values: dict[str, dict[str, Value]] = {message.name: {} for message in self.messages}
        self._next_ns: dict[str, int] = {}
        for name, value in (signals or {}).items():
            self.set(name, value)
        for message in self.messages:
            codec.encode(message.name, self._values[message.name], fill=fill)

    def set(self, name: str, value: Value) -> None:
        """Set "Signal" or "Message.Signal" from now on. If it raises BadSignals or BadValue, nothing changes."""
        holders = [message for message in self.messages if name.rpartition(".")[0] in ("", message.name)]
        signal = name.rpartition(".")[2]
        holders = [message for message in holders if signal in message.signals]
        if not holders:
            there = [one for message in self.messages for one in message.signals]
            raise BadValue(f"{self.node} sends no signal {name!r} in cycles; {near(signal, there)}")
        changed = {message.name: {**self._values[message.name], signal: value} for message in holders}
        for message, values in changed.items():
            self._codec.encode(message, values, fill=self._fill)
        self._values.update(changed)

    def next_ns(self) -> int:
        """When the next frame is due; 0 before the first call of `due`."""
        return min(self._next_ns.values(), default=0)

    def due(self, now_ns: int) -> list[Frame | LinFrame]:
        """The frames to send now: at the first call one of each message, then each at its cycle time.

        Missed cycles are counted in `missed` and not sent later. Raises BadSignals if a plug-in's values are out of
        range.
        """
        return [
            self._made(message)
            for message in self.messages
            if self._next_ns.get(message.name, now_ns) <= now_ns and self._turned(message, now_ns)
        ]

    def run_on(self, node: Any) -> None:
        """Run as this node of a lab; `bus.node(name, script)` calls it."""
        time = node.time

        def turn() -> None:
            for frame in self.due(time.timeline.now_ns):
                try:
                    node.send(frame)
                except QueueFull:
                    self.refused += 1
            time.at(self.next_ns(), turn, background=True)

        time.at(time.timeline.now_ns, turn, background=True)

    def summary(self) -> str:
        """The counts in words: "EngineData 100, Status 10"."""
        return ", ".join(f"{message.name} {self.sent[message.name]}" for message in self.messages)

    def __repr__(self) -> str:
        return f"<simulation of {self.node}: {self.summary()}>"

    def _turned(self, message: MessageDescription, now_ns: int) -> bool:
        """Move the next cycle of the message to a time after `now_ns`; cycles that are already over count as missed."""
        period_ns = max(1, round((message.cycle_s or 0) * _NS))
        late = (now_ns - self._next_ns.get(message.name, now_ns)) // period_ns
        self.missed += late
        self._next_ns[message.name] = self._next_ns.get(message.name, now_ns) + (late + 1) * period_ns
        return True

    def _made(self, message: MessageDescription) -> Frame | LinFrame:
        count = self.sent[message.name]
        self.sent[message.name] += 1
        values = self._codec.complete(message.name, self._values[message.name], fill=self._fill)
        outgoing = OutgoingMessage(self._codec, message.name, count, values, self._fill)
        for plugin in self._plugins:
            plugin(outgoing)
        frame = outgoing.frame()
        return self._codec.protect(frame, count) if isinstance(frame, Frame) else frame
