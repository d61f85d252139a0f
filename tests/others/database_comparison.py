"""One network description, read by us and by cantools: random frames decoded one by one and in columns, and encoded."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from canwire import (
    BadDescription,
    BadSignals,
    Database,
    Frame,
    MessageDescription,
    frames_to_array,
    load_database,
)
from canwire.values.dlc import FD_LENGTHS
from tests.others.told import Told

SUFFIXES = {".dbc", ".kcd", ".sym", ".arxml", ".ldf"}
_FRAMES = 4  # of each message
_Reading = Callable[[Any, bytes], dict[str, Any] | None]


class Difference(NamedTuple):
    """`way` is decode, decode_arrays or encode."""

    message: str
    way: str
    what: str


def compare_database(path: Path) -> Told:
    """What we make of it, beside what cantools (for LDF files, ldfparser) does."""
    if path.suffix.lower() == ".ldf":
        return _compare_ldf(path)
    theirs, ours, why = read_by_both(path)
    why = why.removeprefix(f"{path}: ")
    if ours is None:
        told = "cantools refuses it, too" if theirs is None else "cantools reads it"
        return Told("refused", f"{why} | {told}")
    if theirs is None:
        return Told("alone", f"{len(ours.messages)} messages; cantools refuses it")
    counts: Counter[str] = Counter()
    found = list(differences(ours, theirs, counts))
    wrong = [f"{one.message} by {one.way}: {one.what}" for one in found]
    read = ", ".join(f"{number} {name}" for name, number in counts.items())
    strict = _strictly(path)
    if strict:
        read += f"; strictly refused: {strict}"
    if wrong:
        return Told("differs", f"{len(wrong)} times: {wrong[0]} | {read}")
    return Told("same", read)


def _strictly(path: Path) -> str:
    """Why the file cannot be loaded strictly, "" where it can."""
    try:
        load_database(path)
    except BadDescription as error:
        return str(error).removeprefix(f"{path}: ")[:100]
    return ""


def _compare_ldf(path: Path) -> Told:
    import ldfparser

    try:
        ours = load_database(path)
    except BadDescription as error:
        return Told("refused", str(error))
    theirs = ldfparser.parse_ldf(str(path))
    names = {frame.name for frame in theirs.get_unconditional_frames()}
    if set(ours.messages) != names:
        return Told("differs", f"messages {set(ours.messages) ^ names}")
    return Told("same", f"{len(names)} messages")


def read_by_both(path: Path) -> tuple[Any, Database | None, str]:
    """Read by both, cantools first; None for a refusal, and why we refuse it."""
    import cantools

    try:
        theirs = cantools.database.load_file(path, strict=False)
        theirs = theirs if hasattr(theirs, "messages") else None
    except Exception:  # cantools' many kinds
        theirs = None
    try:
        return theirs, load_database(path, strict=False), ""
    except BadDescription as error:
        return theirs, None, str(error)


def differences(ours: Database, theirs: Any, counts: Counter[str]) -> Iterator[Difference]:
    """What differs in any message, and in `counts` how much was compared."""
    for message, their in zip(ours.messages.values(), theirs.messages, strict=True):
        if not message.decodable or ours.message_of(_frame(message, b"")) is not message:
            continue  # a container, or one whose identifier another message has as well
        counts["messages"] += 1
        reading: _Reading | None = _told if (tidy := _is_tidy(their)) else _alone
        if not _follows(their):
            counts["of them with multiplexers that cantools does not follow"] += 1
            reading = None
        counts["of them with signals that overlap or do not fit"] += not tidy
        if len(their.signals) != len(message.signals):
            counts["messages with signals of one name"] += 1  # which of them counts is anybody's guess
            continue
        chance = random.Random(message.id)
        frames = [_frame(message, chance.randbytes(64)) for _ in range(_FRAMES)]
        yield from _decoded(ours, message, reading, their, frames, counts)
        if tidy and reading:
            yield from _encoded(ours, message, their, frames, counts)


def _frame(message: MessageDescription, data: bytes) -> Frame:
    fd = message.fd or message.length > 8
    length = next(size for size in FD_LENGTHS if size >= min(message.length, 64))
    return Frame(message.id, data.ljust(length, b"\0")[:length], extended=message.extended, fd=fd)


def _decoded(
    ours: Database,
    message: MessageDescription,
    reading: _Reading | None,
    their: Any,
    frames: list[Frame],
    counts: Counter[str],
) -> Iterator[Difference]:
    columns = ours.decode_arrays(frames_to_array(frames))[message.name]
    for row, frame in enumerate(frames):
        told = ours.decode(frame)
        assert told is not None
        expected = dict(told.numbers) if reading is None else reading(their, frame.data)
        in_columns = {
            name: values[row]
            for name, values in columns.signals.items()
            if (here := columns.present[name]) is None or here[row]
        }
        for way, found in (("decode", dict(told.numbers)), ("decode_arrays", in_columns)):
            counts["values decoded"] += len(found)
            if not _equal(found, expected or {}):
                yield Difference(message.name, way, f"{found}, not {expected} ({told.problem})")


def _told(their: Any, data: bytes) -> dict[str, Any] | None:
    """cantools' values; None where it cannot tell any."""
    import cantools

    try:
        return dict(their.decode(data, decode_choices=False, allow_truncated=True))
    except cantools.database.DecodeError:
        return None


def _follows(their: Any) -> bool:
    """False where it loses a multiplexer: by its long name, by m for M; and for one that chooses nothing."""
    named = {signal.multiplexer_signal for signal in their.signals if signal.multiplexer_signal}
    return named == {signal.name for signal in their.signals if signal.is_multiplexer}


def _is_tidy(their: Any) -> bool:
    import cantools

    try:
        their.refresh(strict=True)
    except cantools.database.Error:
        their.refresh(strict=False)
        return False
    return True


def _alone(their: Any, data: bytes) -> dict[str, Any] | None:
    """Of signals that overlap, or do not fit, each one by a message of it and the multiplexers above it alone."""
    found: dict[str, Any] = {}
    for signal in their.signals:
        above, chain = signal, [signal]
        while above.multiplexer_signal:
            above = their.get_signal_by_name(above.multiplexer_signal)
            chain.append(above)
        message = type(their)(their.frame_id, their.name, their.length, chain, strict=False,
                              is_extended_frame=their.is_extended_frame)  # fmt: skip
        values = _told(message, data) if all(_fits(one, their.length) for one in chain) else None
        found |= values or {}
    for name in {signal.multiplexer_signal for signal in their.signals} & found.keys():
        ids = set(their.get_signal_by_name(name).choices or ())
        ids.update(*(one.multiplexer_ids for one in their.signals if one.multiplexer_signal == name))
        if found[name] not in ids:
            return None
    return found


def _fits(signal: Any, length: int) -> bool:
    first = signal.start
    if signal.byte_order == "big_endian":  # bits of a byte count down
        first += 7 - 2 * (first % 8)
    return bool(first + signal.length <= 8 * length)


def _encoded(
    ours: Database, message: MessageDescription, their: Any, frames: list[Frame], counts: Counter[str]
) -> Iterator[Difference]:
    for frame in frames:
        values = _told(their, frame.data)
        try:
            expected = bytes(their.encode(values, strict=False)) if values is not None else None
        except Exception:  # not a number, or a choice that is none: cantools' own and others' errors
            continue
        if expected is None:
            continue
        try:
            found = ours.pack(message.name, values or {})
        except BadSignals:
            counts["refused as out of range"] += 1
            continue
        counts["encoded"] += 1
        if found != expected:
            yield Difference(message.name, "encode", f"{found.hex()}, not {expected.hex()}")


def _equal(found: dict[str, Any], expected: dict[str, Any]) -> bool:
    return found.keys() == expected.keys() and all(
        _same(found[name], value) for name, value in expected.items()
    )


def _same(one: Any, other: Any) -> bool:
    return bool(one == other or (one != one and other != other))  # not a number is not itself
