"""The content of one frame by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from canwire.databases.description import MessageDescription, Number, Value
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame


@dataclass(frozen=True, slots=True)
class DecodedMessage:
    """A decoded frame. `message["EngineSpeed"]` is `message.signals["EngineSpeed"]`.

    `signals` are physical values, or their texts in the file; `numbers` are the same as numbers. Signals that are
    multiplexed out or cut off by short data are missing. `problem` says why nothing could be decoded, "" if all could.
    `frame` contains the time, the data and the identifier. `contained` are the messages in a container, all with the
    frame of the container.
    """

    description: MessageDescription
    signals: Mapping[str, Value]
    numbers: Mapping[str, Number | list[int]]
    frame: Frame | LinFrame
    problem: str = ""
    contained: tuple[DecodedMessage, ...] = ()

    @property
    def name(self) -> str:
        return self.description.name

    @property
    def timestamp_ns(self) -> int:
        """The frame's time in nanoseconds, by the receiver's clock."""
        return self.frame.timestamp_ns

    @property
    def source(self) -> int | None:
        """The sender's address in a J1939 message."""
        return self.frame.id & 0xFF if self.description.j1939 else None

    def __getitem__(self, name: str) -> Value:
        return self.signals[name]

    def agrees(self, wanted: Mapping[str, Value]) -> bool:
        """Whether the message contains these values, as texts or as numbers."""
        return all(
            name in self.signals and value in (self.signals[name], self.numbers[name])
            for name, value in wanted.items()
        )

    def __str__(self) -> str:
        """`EngineData(EngineSpeed: 1500 rpm, Ready: yes)`, as cantools writes it in one line."""
        if self.problem:
            return f"{self.name}({self.problem})"
        parts = [str(message) for message in self.contained]
        parts += [f"{name}: {self.text(name)}" for name in self.signals]
        return f"{self.name}({', '.join(parts)})"

    def text(self, name: str) -> str:
        """A signal's value with its unit, as text."""
        value = self.signals[name]
        if isinstance(value, str):
            return value
        unit = self.description.signals[name].unit
        shown = f"{value:.10g}" if isinstance(value, float) else str(value)
        return f"{shown} {unit}" if unit else shown
