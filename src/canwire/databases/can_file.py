"""DBC, ARXML, KCD and SYM files, read with cantools.

Source: cantools 45; the attributes GenMsgCycleTime, GenSigStartValue, VFrameFormat and CANFD_BRS are Vector's.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from canwire.databases.autosar import Guard, contents_of, guards_in, profile_of, protected
from canwire.databases.description import MessageDescription, Number, SignalDescription, Value
from canwire.databases.one_by_one import read_one_by_one
from canwire.errors import BadDescription, BadValue, ExtraMissing
from canwire.values.frame import Frame

Decoded = dict[str, tuple[Number | list[int], str]]
"""The number and the text ("" for none) of each signal."""


class CanFile:
    """One file; `strict` refuses signals that overlap or do not fit their message, `j1939` overrides the file.

    Raises BadDescription, ExtraMissing.
    """

    def __init__(self, path: Path, encoding: str | None, strict: bool, j1939: bool | None) -> None:
        self._j1939 = j1939
        self._database = _loaded(path, encoding, strict)
        attributes = getattr(self._database.dbc, "attribute_definitions", None) or {}
        told = attributes.get("GenSigStartValue")
        self._usual_start = None if told is None else told.default_value
        self._brs_told = "CANFD_BRS" in attributes
        self.nodes = tuple(node.name for node in self._database.nodes)
        names = _distinct(self._database.messages)
        self.messages = [
            self._message(name, message) for name, message in zip(names, self._database.messages, strict=True)
        ]
        self._by_name = dict(zip(names, self._database.messages, strict=True))
        self._untidy = {
            described.name: described
            for described, message in zip(self.messages, self._database.messages, strict=True)
            if not message.is_container and not (_follows(message) and (strict or _is_tidy(message)))
        }
        self._readings = {name: _readings(message) for name, message in self._by_name.items()}

    def pack(self, name: str, values: Mapping[str, Value]) -> bytes:
        """Return the data of a message with these values, which must be complete and in range."""
        return bytes(self._by_name[name].encode(dict(values), strict=False))

    def unpack(self, name: str, data: bytes) -> tuple[Decoded, str]:
        """Return the signals in the data, and a text: why there are none, or which do not fit into the message."""
        if name in self._untidy:
            raws, problem = read_one_by_one(self._untidy[name], data)
            return {
                signal: _told(*self._readings[name][signal], raw) for signal, raw in raws.items()
            }, problem
        return _unpacked(self._by_name[name], self._readings[name], data)

    def unpack_container(
        self, name: str, data: bytes
    ) -> tuple[list[tuple[MessageDescription, Decoded, str]], str]:
        """Return the messages in a container, each as from `unpack`, and a text: why some are missing."""
        held = {one.name: one for one in self._described(name).contained}
        found, unknown = [], []
        try:
            for message, part in contents_of(self._by_name[name], data):
                if isinstance(message, int):
                    unknown.append(f"{message:06X}")
                else:
                    found.append((held[message.name], *_unpacked(message, _readings(message), part)))
        except import_module("cantools").database.DecodeError as error:
            return found, str(error)
        return found, f"unknown messages in it: {', '.join(unknown)}" if unknown else ""

    def pack_container(self, name: str, parts: Sequence[tuple[str, Mapping[str, Value]]]) -> bytes:
        """Return the data of a container with these messages, with values in range. Raises BadValue if too long."""
        container = self._by_name[name]
        by_name = {one.name: one for one in container.contained_messages}
        data = b"".join(
            by_name[part].header_id.to_bytes(3, "big") + bytes((len(packed),)) + packed
            for part, values in parts
            for packed in [bytes(by_name[part].encode(dict(values), strict=False))]
        )
        if len(data) > container.length:
            raise BadValue(
                f"{name}: {len(data)} bytes with these messages; it has room for {container.length}"
            )
        return data

    def protect(self, name: str, data: bytes, count: int) -> bytes:
        """Return the data with counter and checksum if the file requires them; otherwise unchanged."""
        return protected(self._by_name[name], data, count)

    def guards_in(self, name: str, data: bytes) -> list[Guard]:
        """Return the checksum faults and counters of the message, or of the messages in the container."""
        return guards_in(self._by_name[name], data)

    def _described(self, name: str) -> MessageDescription:
        return next(message for message in self.messages if message.name == name)

    def _message(self, name: str, message: Any) -> MessageDescription:
        signals = {}
        if not message.is_container:
            signals = {one.name: self._signal(one, message) for one in message.signals}
        fd = message.is_fd or self._is_longer(message)
        profile = profile_of(message)
        return MessageDescription(
            name,
            message.frame_id,
            message.length,
            signals,
            extended=message.is_extended_frame,
            fd=fd,
            bit_rate_switch=fd and self._has_bit_rate_switch(message),
            j1939=self._is_j1939(message),
            cycle_s=message.cycle_time / 1000 if message.cycle_time else None,
            senders=tuple(message.senders),
            comment=message.comment or "",
            contained=tuple(self._message(one.name, one) for one in message.contained_messages or ()),
            protection=f"E2E profile {profile.number}" if profile is not None else "",
        )

    def _is_longer(self, message: Any) -> bool:
        """Whether the message must be a CAN FD frame because of its length; False if the file marks FD messages."""
        if "VFrameFormat" in (getattr(self._database.dbc, "attribute_definitions", None) or {}):
            return False
        return 8 < message.length <= 64 and not self._is_j1939(message)

    def _is_j1939(self, message: Any) -> bool:
        if self._j1939 is None:
            return bool(message.protocol == "j1939")
        return self._j1939 and bool(message.is_extended_frame)

    def _has_bit_rate_switch(self, message: Any) -> bool:
        """Whether CANFD_BRS sets the message's bit rate switch; True if the file does not define that attribute."""
        if not self._brs_told:
            return True
        told = message.dbc.attributes.get("CANFD_BRS")
        value = (
            self._database.dbc.attribute_definitions["CANFD_BRS"].default_value
            if told is None
            else told.value
        )
        return str(value) == "1"

    def _signal(self, signal: Any, message: Any) -> SignalDescription:
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
            multiplexer=_multiplexer(signal, message),
            multiplexer_ids=tuple(signal.multiplexer_ids or ()),
            spn=signal.spn,
        )


def _unpacked(message: Any, readings: Mapping[str, tuple[Any, Any]], data: bytes) -> tuple[Decoded, str]:
    try:
        raws = message.decode(data, decode_choices=False, scaling=False, allow_truncated=True)
    except import_module("cantools").database.DecodeError as error:
        return {}, str(error)
    return {signal: _told(*readings[signal], raw) for signal, raw in raws.items()}, ""


def _follows(message: Any) -> bool:
    """Whether cantools knows each multiplexer that a signal refers to, and each multiplexer selects signals."""
    named = {signal.multiplexer_signal for signal in message.signals} - {None}
    return named == {signal.name for signal in message.signals if signal.is_multiplexer}


def _is_tidy(message: Any) -> bool:
    """Whether all signals fit into the message and do not overlap."""
    try:
        message.refresh(strict=True)
    except import_module("cantools").database.Error:
        message.refresh(strict=False)
        return False
    return True


def _distinct(messages: Sequence[Any]) -> list[str]:
    """Return a unique name for each message: its name, with its identifier in hex if several have the same name."""
    counts = Counter(message.name for message in messages)
    names: list[str] = []
    for message in messages:
        name = message.name if counts[message.name] == 1 else f"{message.name}_{message.frame_id:X}"
        number = 2
        while name in names:
            name, number = f"{message.name}_{message.frame_id:X}_{number}", number + 1
        names.append(name)
    return names


def _multiplexer(signal: Any, message: Any) -> str:
    """Return the multiplexer's name as it is in the message; for a long name cantools gives the short one."""
    told = signal.multiplexer_signal
    if not told or any(one.name == told for one in message.signals):
        return told or ""
    near = [one.name for one in message.signals if one.is_multiplexer]
    longer = [name for name in near if name.startswith(told[:28])]
    return str((longer or near or [""])[0])


def _readings(message: Any) -> dict[str, tuple[Any, Any]]:
    """Return by signal the function from raw to physical values, and the texts of the values (None without texts)."""
    return {
        signal.name: (
            signal.conversion.raw_to_scaled,
            None if signal.conversion.is_float else signal.conversion.choices,
        )
        for signal in message.signals
    }


def _told(scaled: Any, choices: Any, raw: Number) -> tuple[Number, str]:
    return scaled(raw, False), str(choices.get(raw, "")) if choices else ""


def _limits(signal: Any) -> tuple[float, float]:
    """Return the smallest and largest physical value: the file's limits, restricted to the range of the bits."""
    if signal.conversion.is_float:
        ends = [float("-inf"), float("inf")]
    else:
        bits = signal.length
        raw = (-(1 << bits - 1), (1 << bits - 1) - 1) if signal.is_signed else (0, (1 << bits) - 1)
        ends = sorted(_as_float(signal.conversion.raw_to_scaled(one, False)) for one in raw)
    low = ends[0] if signal.minimum is None else max(ends[0], float(signal.minimum))
    high = ends[1] if signal.maximum is None else min(ends[1], float(signal.maximum))
    return (low, high) if low <= high else (ends[0], ends[1])


def _as_float(number: Any) -> float:
    try:
        return float(number)
    except OverflowError:  # of more than 1023 bits: J1939's texts
        return float("inf") if number > 0 else float("-inf")


def _loaded(path: Path, encoding: str | None, strict: bool) -> Any:
    try:
        cantools = import_module("cantools")
    except ModuleNotFoundError:
        raise ExtraMissing("cantools", "databases") from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # from the parsers of cantools
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
    """Return the frame with these data; CAN FD data are padded with zeros to the next valid length."""
    if message.fd:
        from canwire.values.dlc import FD_LENGTHS

        length = next((length for length in FD_LENGTHS if length >= len(data)), 0)
        data = data.ljust(length, b"\0")
    return Frame(id, data, extended=message.extended, fd=message.fd, bit_rate_switch=message.bit_rate_switch)
