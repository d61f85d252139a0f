"""Which frames and events are shown: by identifier, candump's filters among them, and by kind.

123         this identifier; eight digits mean a 29-bit one
100-1FF     these and all between
123:7FF     candump's: the bits of the identifier where the mask has ones
~123        all others; ~100-1FF likewise, and candump's 123~7FF
j           candump's: all filters have to let a frame in, not any of them
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from canwire import BadValue, BusEvent, EventKind, Frame

_HEX = "[0-9A-Fa-f]{1,8}"
_MASKED = re.compile(rf"(?P<code>{_HEX})(?P<kind>[:~])(?P<mask>{_HEX})")
_SPAN = re.compile(rf"(?P<not>~?)(?P<first>{_HEX})(?:-(?P<last>{_HEX}))?")
_LONGEST_STANDARD = 3  # hex digits: more of them mean a 29-bit identifier
_LARGEST = 0x1FFF_FFFF
_JOIN = "j"

FRAME_KINDS = {
    "data": "type",
    "remote": "type",
    "classic": "format",
    "fd": "format",
    "standard": "identifier",
    "extended": "identifier",
}
EVENT_KINDS = {"error": EventKind.ERROR, "state": EventKind.STATE}
KINDS = (*FRAME_KINDS, *EVENT_KINDS)


class Masked(NamedTuple):
    """Lets in what has `code` where `mask` has ones, or with `inverted` what has not."""

    code: int
    mask: int
    extended: bool
    inverted: bool

    def accepts(self, frame: Frame) -> bool:
        met = frame.extended == self.extended and (frame.id ^ self.code) & self.mask == 0
        return met != self.inverted


class Span(NamedTuple):
    """Lets in identifiers from `first` to `last`, or with `inverted` all others."""

    first: int
    last: int
    extended: bool
    inverted: bool

    def accepts(self, frame: Frame) -> bool:
        met = frame.extended == self.extended and self.first <= frame.id <= self.last
        return met != self.inverted


_NOTHING = Span(1, 0, extended=False, inverted=False)


class Capture(NamedTuple):
    """What passes: frames that any filter lets in (with `joined` all of them), of these kinds (none: every kind).

    Kinds of one group, data and remote say, add up; groups all count. Events pass where `events` has their kind.
    `named` are more filters by channel, of messages that a channel's databases know; see `of`.
    """

    filters: tuple[Masked | Span, ...] = ()
    joined: bool = False
    kinds: tuple[str, ...] = ()
    events: tuple[EventKind, ...] = ()
    named: Mapping[str, tuple[Masked, ...]] = MappingProxyType({})

    def of(self, channel: str) -> Capture:
        """What passes on this channel; none of the messages where its databases know none of them."""
        if not self.named:
            return self
        return self._replace(filters=(*self.filters, *(self.named.get(channel) or (_NOTHING,))), named={})

    def accepts(self, content: Frame | BusEvent) -> bool:
        if isinstance(content, BusEvent):
            return content.kind in self.events
        if self.kinds and not self._of_these_kinds(content):
            return False
        if not self.filters:
            return True
        met = (each.accepts(content) for each in self.filters)
        return all(met) if self.joined else any(met)

    def _of_these_kinds(self, frame: Frame) -> bool:
        is_kind = {
            "remote" if frame.remote else "data",
            "fd" if frame.fd else "classic",
            "extended" if frame.extended else "standard",
        }
        wanted = [kind for kind in self.kinds if kind in FRAME_KINDS]
        groups = {FRAME_KINDS[kind] for kind in wanted}
        met = {FRAME_KINDS[kind] for kind in wanted if kind in is_kind}
        return bool(wanted) and met == groups


def parse_capture(filters: Sequence[str], kinds: Sequence[str], errors: bool) -> Capture:
    """The capture of all --filter and --kind options, each with one or more items between commas, and of -e; raises
    BadValue."""
    parts = [part for text in filters for part in text.split(",")]
    found = tuple(_parsed(part) for part in parts if part != _JOIN)
    named = tuple(part for text in kinds for part in text.split(","))
    for kind in named:
        if kind not in KINDS:
            raise BadValue(f"--kind {kind}: {', '.join(KINDS)}")
    events = tuple(event for kind, event in EVENT_KINDS.items() if errors or kind in named)
    return Capture(found, _JOIN in parts, named, events)


def _parsed(text: str) -> Masked | Span:
    if found := _MASKED.fullmatch(text):
        code, extended = _identifier(text, found["code"])
        return Masked(code, int(found["mask"], 16) & _LARGEST, extended, found["kind"] == "~")
    span = _SPAN.fullmatch(text)
    if span is None:
        raise BadValue(
            f"--filter {text!r}: an identifier in hex, with a mask (123:7FF, 123~7FF for all others) or a last one "
            "(100-1FF)"
        )
    first, extended = _identifier(text, span["first"])
    last, also_extended = _identifier(text, span["last"]) if span["last"] else (first, extended)
    if last < first or extended != also_extended:
        raise BadValue(
            f"--filter {text}: from the lower to the higher identifier, both of 3 or both of 8 digits"
        )
    return Span(first, last, extended, bool(span["not"]))


def _identifier(text: str, digits: str) -> tuple[int, bool]:
    code, extended = int(digits, 16), len(digits) > _LONGEST_STANDARD
    if code > (_LARGEST if extended else 0x7FF):
        raise BadValue(f"--filter {text}: {digits} is no identifier of {29 if extended else 11} bits")
    return code, extended
