"""Channels whose variables are in another process."""

from __future__ import annotations

import pytest

from canwire import BadValue, Frame
from canwire.acan.constants import Action
from canwire.acan.filters import Elsewhere, Filter


class Place(Elsewhere):
    def __init__(self, held: bytes = b"") -> None:
        self.held = held
        self.written: list[bytes] = []

    def read(self) -> bytes:
        return self.held

    def write(self, data: bytes) -> None:
        self.written.append(data)


def test_a_channel_writes_what_it_receives_there() -> None:
    place = Place()
    channel = Filter(0, 0, Action.CHANRCV, place, 2)
    for data in (b"\1", b"", b"\1\2\3"):
        assert channel.transfer(Frame(1, data)) is None
    assert place.written == [b"\1", b"\1\2"]


def test_a_channel_sends_what_is_there_when_it_is_asked() -> None:
    place = Place(b"\1\2\3")
    channel = Filter(0, 0, Action.CHANSND, place, 2)
    place.held = b"\7\x08\x09"
    asked = Frame(1, (0x201 << 18).to_bytes(4, "little") + b"\0\2")
    assert channel.transfer(asked) == Frame(0x201, b"\7\x08")
    place.held = b""  # that memory is gone
    assert channel.transfer(asked) == Frame(0x201)


def test_memory_that_cannot_be_read_is_refused() -> None:
    with pytest.raises(BadValue, match="lpAddress"):
        Filter(0, 0, Action.CHANSND, Place(b""), 2)
