"""Which frames are shown: candump's filters, `123:7FF` and inverted `123~7FF`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from canwire import BadValue, BusEvent, Frame

_FILTER = re.compile(r"(?P<code>[0-9A-Fa-f]{1,8})(?P<kind>[:~])(?P<mask>[0-9A-Fa-f]{1,8})")
_LONGEST_STANDARD = 3  # hex digits: more of them mean a 29-bit identifier
_LARGEST = 0x1FFF_FFFF


class Filter(NamedTuple):
    """Lets in what has `code` where `mask` has ones, or with `inverted` what has not."""

    code: int
    mask: int
    extended: bool
    inverted: bool

    def accepts(self, frame: Frame) -> bool:
        met = frame.extended == self.extended and (frame.id ^ self.code) & self.mask == 0
        return met != self.inverted


def parse_filters(texts: Sequence[str]) -> list[Filter]:
    """Those of every --filter, which may hold several with commas between them; raises BadValue."""
    return [_parsed(part) for text in texts for part in text.split(",")]


def accepts(filters: Sequence[Filter], content: Frame | BusEvent) -> bool:
    """Events always pass; a frame where any filter lets it, or there is none."""
    if not filters or not isinstance(content, Frame):
        return True
    return any(each.accepts(content) for each in filters)


def _parsed(text: str) -> Filter:
    found = _FILTER.fullmatch(text)
    if found is None:
        raise BadValue(
            f"--filter {text!r}: an identifier and a mask in hex: 123:7FF, or 123~7FF for all others"
        )
    code, mask = int(found["code"], 16), int(found["mask"], 16)
    extended = len(found["code"]) > _LONGEST_STANDARD
    if code > (_LARGEST if extended else 0x7FF):
        raise BadValue(f"--filter {text}: {found['code']} is no identifier of {29 if extended else 11} bits")
    return Filter(code, mask & _LARGEST, extended, found["kind"] == "~")
