"""CANSPY's notation of a frame, and how it is read back to send one.

10:04:17 - 00001001000 - 61 | a                   a time, 11 binary digits, - for data, bytes, characters
10:04:17 - 00001001000 R                          a remote frame
10:04:17 - 00001001000000000000000000001 R 4      29 digits: extended; it asks for 4 bytes
00001001000 - 61 62                               to send: the time may be left out, and the characters
00001001000 - | ab                                or the bytes

A remote frame's length is ours, and shown only where it is not 0: the manual's notation has no place for it.
Source: INduCAN104 manual, "CAN Spy".
"""

from __future__ import annotations

import re

from canwire import BadText, Frame

_STANDARD, _EXTENDED = 11, 29
_CLOCK = re.compile(r"\s*(\d\d:\d\d:\d\d) - ")
_HEAD = re.compile(r"\s*([01]+)\s+([R-])(?=[\s|]|\Z)", re.IGNORECASE)
_BYTES = re.compile(r"(?:[0-9A-Fa-f]{2}(?:\s+|\Z))*")
_USAGE = "like 00001001000 - 61 62, 00001001000 - | ab or 00001001000 R"


def format_message(frame: Frame) -> str:
    """A classic frame without a time: `00001001000 - 61 | a`."""
    digits = format(frame.id, f"0{_EXTENDED if frame.extended else _STANDARD}b")
    if frame.remote:
        return f"{digits} R {frame.dlc}" if frame.dlc else f"{digits} R"
    if not frame.data:
        return f"{digits} -"
    return f"{digits} - {frame.data.hex(' ').upper()} | {_characters(frame.data)}"


def format_trace_line(clock: str, frame: Frame) -> str:
    """`clock` is hh:mm:ss."""
    return f"{clock} - {format_message(frame)}"


def parse_trace_line(text: str) -> tuple[str, Frame]:
    """The time and the frame of a whole line; raises BadText."""
    found = _CLOCK.match(text)
    if not found:
        raise BadText(f"{text!r}: no time hh:mm:ss in front")
    return found[1], parse_message(text[found.end() :])


def parse_message(text: str) -> Frame:
    """The frame, with or without a time in front. Raises BadText; BadFrame is one for values no bus carries."""
    clock = _CLOCK.match(text)
    rest = text[clock.end() :] if clock else text
    head = _HEAD.match(rest)
    if not head:
        raise BadText(f"{text!r}: {_USAGE}")
    digits = head[1]
    if len(digits) not in (_STANDARD, _EXTENDED):
        raise BadText(f"{text!r}: {len(digits)} binary digits; an identifier has 11, or 29 if extended")
    extended = len(digits) == _EXTENDED
    tail = rest[head.end() :]
    if head[2] in "Rr":
        return Frame(int(digits, 2), extended=extended, remote=True, dlc=_requested(text, tail))
    return Frame(int(digits, 2), _data(text, tail), extended=extended)


def _requested(text: str, tail: str) -> int:
    """Bytes that a remote frame asks for."""
    wanted = tail.strip()
    if not wanted:
        return 0
    if not re.fullmatch("[0-8]", wanted):
        raise BadText(f"{text!r}: after R comes nothing, or the number of bytes asked for, 0 to 8")
    return int(wanted)


def _data(text: str, tail: str) -> bytes:
    """Hexadecimal bytes, or characters behind |, or both if they agree."""
    numbers, bar, characters = tail.partition("|")
    numbers = numbers.strip()
    if not _BYTES.fullmatch(numbers):
        raise BadText(
            f"{text!r}: {numbers!r} are no bytes of two hexadecimal digits; characters stand behind |"
        )
    data = bytes.fromhex("".join(numbers.split()))  # blanks of Unicode's, too
    characters = characters.removeprefix(" ")
    if not numbers and characters:
        data = _encoded(text, characters)
    elif bar and characters.rstrip() not in ("", _characters(data).rstrip()):
        raise BadText(
            f"{text!r}: the bytes read {_characters(data)!r}; give them or the characters, not both"
        )
    if len(data) > 8:
        raise BadText(f"{text!r}: {len(data)} bytes; a message has 8 at most")
    return data


def _encoded(text: str, characters: str) -> bytes:
    try:
        return characters.encode("latin-1")
    except UnicodeEncodeError:
        raise BadText(f"{text!r}: not all of these characters are bytes; write them in hexadecimal") from None


def _characters(data: bytes) -> str:
    """ASCII; a dot for what cannot be shown."""
    return "".join(chr(byte) if 0x20 <= byte < 0x7F else "." for byte in data)
