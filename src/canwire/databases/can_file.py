"""DBC, ARXML, KCD and SYM files by cantools, which nobody else here knows of.

Source: cantools 45; the attributes GenMsgCycleTime, GenSigStartValue, VFrameFormat and CANFD_BRS are Vector's.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from canwire.databases.description import MessageDescription, Number, SignalDescription, Value
from canwire.errors import BadDescription, ExtraMissing
from canwire.values.frame import Frame

Decoded = dict[str, tuple[Number | list[int], str]]
"""Number and text ("" for none) by signal."""


class CanFile:
    """One file; `strict` refuses signals that overlap or do not fit their message.

    Raises BadDescription, ExtraMissing.
    """

    def __init__(self, path: Path, encoding: str | None, strict: bool) -> None:
        self._database = _loaded(path, encoding, strict)
        attributes = getattr(self._database.dbc, "attribute_definitions", None) or {}
        told = attributes.get("GenSigStartValue")
        self._usual_start = None if told is None else told.default_value
        self._brs_told = "CANFD_BRS" in attributes
        self.nodes = tuple(node.name for node in self._database.nodes)
        self.messages = [self._message(message) for message in self._database.messages]
        self._by_name = {message.name: message for message in self._database.messages}

    def pack(self, name: str, values: Mapping[str, Value]) -> bytes:
        """The data of a message with these values, which fit and are all that it needs."""
        return bytes(self._by_name[name].encode(dict(values), strict=False))

    def unpack(self, name: str, data: bytes) -> tuple[Decoded, str]:
        """The signals that are in the data, and why there are none."""
        message = self._by_name[name]
        if message.is_container:
            return {}, "it holds other messages, which are not decoded"
        try:
            raws = message.decode(data, decode_choices=False, scaling=False, allow_truncated=True)
        except import_module("cantools").database.DecodeError as error:
            return {}, str(error)
        return {signal: _told(message.get_signal_by_name(signal), raw) for signal, raw in raws.items()}, ""

    def _message(self, message: Any) -> MessageDescription:
        signals = {} if message.is_container else {one.name: self._signal(one) for one in message.signals}
        return MessageDescription(
            message.name,
            message.frame_id,
            message.length,
            signals,
            extended=message.is_extended_frame,
            fd=message.is_fd,
            bit_rate_switch=message.is_fd and self._has_bit_rate_switch(message),
            j1939=message.protocol == "j1939",
            cycle_s=message.cycle_time / 1000 if message.cycle_time else None,
            senders=tuple(message.senders),
            comment=message.comment or "",
            decodable=not message.is_container,
        )

    def _has_bit_rate_switch(self, message: Any) -> bool:
        """What CANFD_BRS says; where a file does not have it, FD frames have the switch."""
        if not self._brs_told:
            return True
        told = message.dbc.attributes.get("CANFD_BRS")
        value = (
            self._database.dbc.attribute_definitions["CANFD_BRS"].default_value
            if told is None
            else told.value
        )
        return str(value) == "1"

    def _signal(self, signal: Any) -> SignalDescription:
        low, high = _limits(signal)
        conversion = signal.conversion
        start = self._usual_start if signal.raw_initial is None else signal.raw_initial
        return SignalDescription(
            signal.name,
            signal.start,
            signal.length,
            low,
            high,
            big_endian=signal.byte_order == "big_endian",
            signed=signal.is_signed,
            is_float=conversion.is_float,
            scale=conversion.scale,
            offset=conversion.offset,
            unit="" if signal.unit in (None, "None") else signal.unit,
            comment=signal.comment or "",
            choices={raw: str(text) for raw, text in (conversion.choices or {}).items()},
            start=None if start is None else conversion.raw_to_scaled(start, False),
            multiplexer=signal.multiplexer_signal or "",
            multiplexer_ids=tuple(signal.multiplexer_ids or ()),
            spn=signal.spn,
        )


def _told(signal: Any, raw: Number) -> tuple[Number, str]:
    choices = signal.conversion.choices
    text = "" if not choices or signal.conversion.is_float else str(choices.get(raw, ""))
    return signal.conversion.raw_to_scaled(raw, False), text


def _limits(signal: Any) -> tuple[float, float]:
    """The least and the greatest value: those told, within what the bits can say."""
    if signal.conversion.is_float:
        ends = [float("-inf"), float("inf")]
    else:
        bits = signal.length
        raw = (-(1 << bits - 1), (1 << bits - 1) - 1) if signal.is_signed else (0, (1 << bits) - 1)
        ends = sorted(float(signal.conversion.raw_to_scaled(one, False)) for one in raw)
    low = ends[0] if signal.minimum is None else max(ends[0], float(signal.minimum))
    high = ends[1] if signal.maximum is None else min(ends[1], float(signal.maximum))
    return (low, high) if low <= high else (ends[0], ends[1])


def _loaded(path: Path, encoding: str | None, strict: bool) -> Any:
    try:
        cantools = import_module("cantools")
    except ModuleNotFoundError:
        raise ExtraMissing("cantools", "databases") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its own parsers
            database = cantools.database.load_file(path, encoding=encoding, strict=strict)
    except OSError as error:
        raise BadDescription(f"{path}: {error.strerror}") from None
    except Exception as error:  # somebody else's parsers: anything may come
        raise BadDescription(f"{path}: {_first_line(error)}") from error
    if not hasattr(database, "messages"):
        raise BadDescription(f"{path}: it describes diagnostics, not messages of a bus")
    return database


def _first_line(error: Exception) -> str:
    text = str(error).strip().splitlines()
    return text[0] if text else type(error).__name__


def frame_of(message: MessageDescription, id: int, data: bytes) -> Frame:
    """The frame with these data; those of CAN FD are filled with zeros up to a length that there is."""
    if message.fd:
        from canwire.values.dlc import FD_LENGTHS

        length = next((length for length in FD_LENGTHS if length >= len(data)), 0)
        data = data.ljust(length, b"\0")
    return Frame(id, data, extended=message.extended, fd=message.fd, bit_rate_switch=message.bit_rate_switch)
