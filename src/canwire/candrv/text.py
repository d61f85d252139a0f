"""Messages and events as text: the grammars of WriteFile and ReadFile, and parsers for both.

    731 0 4 11 22 33 44\\n                                          -> Message(0x731, 0, 4, b"\\x11\\x22\\x33\\x44")
    received\\t0:12568\\t00000112\\t1\\t0\\r\\n\\t5\\n                    <- an event

The output follows exactly the grammar of 8.4, with hex digits in lower case, as %x prints them, and with the bytes that
the message has: none in a remote frame, eight above DLC 8. The parsers also accept the shorter form of the manual's
examples.
Source: CANDRV manual, 8.3, 8.4; rulings.md 14.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple, Never

from canwire import BadText
from canwire.candrv.constants import CanbusEvent
from canwire.candrv.event_queue import Event

DWORD = 0xFFFF_FFFF
MOST_FIELDS = 11  # identifier, RTR, DLC, eight bytes; what follows is ignored


class Message(NamedTuple):
    """A message for WriteFile: `identifier` is aligned by Align, `dlc` is 0..15, `data` up to eight bytes."""

    identifier: int
    rtr: int = 0
    dlc: int = 0
    data: bytes = b""


class MalformedMessage(BadText):
    """Text that is no message; `consumed` is the number of characters of the call before the wrong one."""

    def __init__(self, why: str, consumed: int) -> None:
        super().__init__(f"{why}, at character {consumed + 1}")
        self.consumed = consumed


def format_message(message: Message) -> bytes:
    """The text of a message for WriteFile."""
    numbers = (message.identifier, message.rtr, message.dlc, *message.data)
    return " ".join(f"{number:x}" for number in numbers).encode() + b"\n"


# WriteFile: hex numbers, separated by any characters that are no hex digits, until CR, LF or NUL

_TOKEN = re.compile(rb"([0-9A-Fa-f]+)|([\r\n\0])|[^0-9A-Fa-f\r\n\0]+")
_GAP = rb"[^0-9A-Fa-f\r\n\0]"
_WHOLE = re.compile(
    rb"%b*([0-9A-Fa-f]{1,8})%b+([01])%b+([0-9A-Fa-f])((?:%b+[0-9A-Fa-f]{1,2})*+)%b*+[\r\n\0]" % ((_GAP,) * 5)
)
_BYTE = re.compile(rb"[0-9A-Fa-f]+")
_FIELDS = (("identifier", DWORD), ("RTR", 1), ("DLC", 15), *((f"data byte {i}", 0xFF) for i in range(8)))


class MessageParser:
    """Parses messages in text that arrives in pieces of any length.

    A malformed message is discarded, and the next call begins a new one.
    """

    __slots__ = ("_fields", "_number")

    def __init__(self) -> None:
        self._fields: list[int] = []
        self._number = -1  # the number that further digits may continue, -1 between numbers

    @property
    def pending(self) -> bool:
        """Whether a message has begun but not ended."""
        return bool(self._fields) or self._number >= 0

    def reset(self) -> None:
        """Discard the message that has begun."""
        self._fields.clear()
        self._number = -1

    def next(self, text: bytes, start: int = 0) -> tuple[Message | None, int]:
        """The next message in the text from `start` on, and the position after it.

        The message is None if the text ends before it: then all of the text is used. Empty lines are ignored.
        Raises MalformedMessage.
        """
        if not self.pending and (whole := _WHOLE.match(text, start)) and (found := _quick(whole)):
            return found, whole.end()
        for token in _TOKEN.finditer(text, start):
            if token[1]:
                self._digits(token[1], token.start())
            else:
                self._end_number()
                if token[2] and self._fields:
                    return self._message(token.start()), token.end()
        return None, len(text)

    def messages(self, text: bytes) -> Iterator[Message]:
        """All messages that end in the text."""
        found, at = self.next(text)
        while found is not None:
            yield found
            found, at = self.next(text, at)

    def _digits(self, digits: bytes, at: int) -> None:
        name, limit = self._field()
        if limit is None:  # a number after the last data byte is ignored
            self._number = 0
            return
        number = max(self._number, 0)
        for place, digit in enumerate(digits):
            number = number << 4 | int(chr(digit), 16)
            if number > limit:
                self._refuse(f"{name} is more than {limit:X} (hex)", at + place)
        self._number = number

    def _field(self) -> tuple[str, int | None]:
        fields = self._fields
        if len(fields) >= 3 and len(fields) >= 3 + _bytes_in(fields[1], fields[2]):
            return "", None
        return _FIELDS[len(fields)]

    def _end_number(self) -> None:
        if self._number >= 0 and len(self._fields) < MOST_FIELDS:
            self._fields.append(self._number)
        self._number = -1

    def _message(self, at: int) -> Message:
        fields = self._fields
        if len(fields) < 3:
            self._refuse(f"the message ends before its {_FIELDS[len(fields)][0]}", at)
        identifier, rtr, dlc = fields[:3]
        wanted, given = _bytes_in(rtr, dlc), len(fields) - 3
        if given < wanted:
            self._refuse(f"the message ends after {given} of {wanted} data bytes", at)
        self._fields = []
        return Message(identifier, rtr, dlc, bytes(fields[3 : 3 + wanted]))

    def _refuse(self, why: str, at: int) -> Never:
        self.reset()
        raise MalformedMessage(why, at)


def _quick(whole: re.Match[bytes]) -> Message | None:
    """A message whose text is in one piece; None if the slow parser must find out what is wrong with it."""
    rtr, dlc = int(whole[2]), int(whole[3], 16)
    wanted = _bytes_in(rtr, dlc)
    numbers = _BYTE.findall(whole[4])
    if len(numbers) < wanted:
        return None
    data = bytes([int(number, 16) for number in numbers[:wanted]])
    return Message(int(whole[1], 16), rtr, dlc, data)


def _bytes_in(rtr: int, dlc: int) -> int:
    return 0 if rtr else min(dlc, 8)


# ReadFile: an event

WORDS = {
    CanbusEvent.RECEIVED: "received",
    CanbusEvent.TRANSMITTED: "transmitted",
    CanbusEvent.ABORTED: "aborted",
    CanbusEvent.ARBITRATION_LOST: "arbitration lost",
    CanbusEvent.DEVICE_CHANGED: "device changed",
    CanbusEvent.ENTERING_STANDBY: "entering standby",
    CanbusEvent.LEAVING_STANDBY: "leaving standby",
    CanbusEvent.OVERRUN: "overrun",
    CanbusEvent.WARNING: "warning",
    CanbusEvent.PASSIVE: "passive",
    CanbusEvent.BUS_ERROR: "bus error",
}
_WORD_OF = {int(event): word for event, word in WORDS.items()}
_EVENT_OF = {word: event for event, word in _WORD_OF.items()}
_RECEIVED = int(CanbusEvent.RECEIVED)
_MESSAGES = {  # with %, which is a fifth quicker than an f-string
    kind: _WORD_OF[kind] + "\t%d:%d\t%08x\t%d\t%d\r\n%s%s"
    for kind in (_RECEIVED, int(CanbusEvent.TRANSMITTED), int(CanbusEvent.ABORTED))
}


def format_event(event: Event) -> bytes:
    """The event as ReadFile returns it: ASCII, ended by a line feed."""
    kind, time, lost, _, identifier, rtr, dlc, data = event
    if kind not in _MESSAGES:
        word = _WORD_OF.get(kind) or f"unknown event {kind}"
        return f"{word}\t{time >> 32}:{time & DWORD}\n".encode()
    shown = "\t" + data.hex("\t") if data else ""
    end = f"\t{lost}\n" if kind == _RECEIVED else "\n"
    return (_MESSAGES[kind] % (time >> 32, time & DWORD, identifier, rtr, dlc, shown, end)).encode()


_UNKNOWN = re.compile(r"unknown event ([0-9]{1,10})")
_TIME = re.compile(r"([0-9]{1,10}):([0-9]{1,10})")
_FIELD = {"identifier": (re.compile(r"[0-9A-Fa-f]{1,8}"), 16), "byte": (re.compile(r"[0-9A-Fa-f]{1,2}"), 16)}
_DECIMAL = re.compile(r"[0-9]{1,10}")


def parse_event(text: bytes | str) -> Event:
    """Parses one event in either form. Its `fmt` is 0, since the text does not contain it. Raises BadText."""
    line = text.decode("ascii", "replace") if isinstance(text, bytes) else text
    fields = [field for field in re.split(r"[\t\r\n]+|  +", line) if field]
    if len(fields) < 2 or not (time := _TIME.fullmatch(fields[1])):
        raise BadText(f"{line!r:.80}: no event with its time as high:low")
    unknown = _UNKNOWN.fullmatch(fields[0])
    kind = _decimal(line, unknown[1], DWORD) if unknown else _EVENT_OF.get(fields[0], -1)
    moment = _decimal(line, time[1], DWORD) << 32 | _decimal(line, time[2], DWORD)
    if kind < 0:
        raise BadText(f"{line!r:.80}: {fields[0]!r:.40} is no event")
    if kind not in _MESSAGES:
        if len(fields) > 2:
            raise BadText(f"{line!r:.80}: more than a time, although this event has no message")
        return Event(kind, moment)
    return _parse_message(line, kind, moment, fields[2:])


def _parse_message(line: str, kind: int, time: int, fields: list[str]) -> Event:
    if len(fields) < 3:
        raise BadText(f"{line!r:.80}: identifier, RTR and DLC are missing")
    identifier = _hex(line, "identifier", fields[0])
    rtr, dlc = _decimal(line, fields[1], 1), _decimal(line, fields[2], 15)
    count = _bytes_in(rtr, dlc)
    rest = fields[3:]
    if len(rest) != count + (kind == _RECEIVED):
        raise BadText(
            f"{line!r:.80}: DLC {dlc} needs {count} bytes" + " and the count of lost events" * (kind == 1)
        )
    data = bytes(_hex(line, "byte", field) for field in rest[:count])
    lost = _decimal(line, rest[count], DWORD) if kind == _RECEIVED else 0
    return Event(kind, time, lost, 0, identifier, rtr, dlc, data)


def _hex(line: str, kind: str, field: str) -> int:
    pattern, base = _FIELD[kind]
    if not pattern.fullmatch(field):
        raise BadText(f"{line!r:.80}: {field!r:.20} is no {kind}")
    return int(field, base)


def _decimal(line: str, field: str, limit: int) -> int:
    if not _DECIMAL.fullmatch(field) or (value := int(field)) > limit:
        raise BadText(f"{line!r:.80}: {field!r:.20} is no number from 0 to {limit}")
    return value


_END = re.compile(rb"(?<!\r)\n")
LONGEST_EVENT = 200  # characters; all events are shorter


class EventReader:
    """Parses ReadFile's text in pieces of any length: an event ends with a line feed without a carriage return."""

    __slots__ = ("_at", "_text")

    def __init__(self) -> None:
        self._text = b""
        self._at = 0  # where the next event begins

    def feed(self, text: bytes) -> Iterator[Event]:
        """The events that end in the text. A malformed one raises BadText; feed(b"") then continues after it."""
        self._text = self._text[self._at :] + text
        self._at = 0
        return self._events()

    def _events(self) -> Iterator[Event]:
        while found := _END.search(self._text, self._at):
            one, self._at = self._text[self._at : found.end()], found.end()
            if one.strip(b"\r\n\t "):
                yield parse_event(one)
        if len(self._text) - self._at > LONGEST_EVENT:
            one, self._text, self._at = self._text[self._at :], b"", 0
            raise BadText(f"{one[:40]!r}: {len(one)} characters without the end of an event")
