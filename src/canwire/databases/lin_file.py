"""LDF files: `canwire.ldf` with the interface of other databases."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from canwire import ldf
from canwire.databases.can_file import Decoded
from canwire.databases.description import MessageDescription, SignalDescription, Value
from canwire.values.lin.frame import LinFrame


class LinFile:
    """One file; raises BadDescription, ExtraMissing. `network` holds the rest of the file: nodes, schedules."""

    def __init__(self, path: Path, encoding: str | None) -> None:
        self.network = ldf.load(path, encoding=encoding or "utf-8")
        self.nodes = (self.network.master, *self.network.slaves)
        self.messages = [self._message(frame) for frame in self.network.frames.values()]

    def pack(self, name: str, values: Mapping[str, Value]) -> LinFrame:
        """The frame with these values."""
        return self.network.encode(name, values)  # type: ignore[arg-type]  # arrays are lists, here as there

    def name_of(self, frame: LinFrame) -> str | None:
        """Return the name of a received frame's message, by its first byte if event-triggered; None if unknown."""
        from canwire.errors import BadFrame

        try:
            return self.network.described(frame).name
        except BadFrame:
            return None

    def unpack(self, frame: LinFrame) -> tuple[Decoded, str]:
        """Return the signals, and a text: why there are none."""
        from canwire.errors import BadFrame

        try:
            raw, shown = self.network.decode_raw(frame), self.network.decode(frame)
        except BadFrame as error:
            return {}, str(error)
        return {
            name: (raw[name], value) if isinstance(value, str) else (value, "")
            for name, value in shown.items()
        }, ""

    def _message(self, frame: ldf.FrameDescription) -> MessageDescription:
        signals = {signal.name: _signal(signal) for signal in self.network.signals_of(frame.name)}
        senders = (frame.publisher,)
        return MessageDescription(frame.name, frame.id, frame.length, signals, lin=True, senders=senders)


def _signal(signal: ldf.LinSignal) -> SignalDescription:
    return SignalDescription(
        signal.name,
        signal.start_bit,
        signal.length,
        signal.minimum,
        signal.maximum,
        scale=signal.scale,
        offset=signal.offset,
        unit=signal.unit,
        choices=signal.texts,
        start=signal.start,
    )
