"""Errors on their way to a client, and requests whose serial number nobody can tell."""

from __future__ import annotations

import msgspec
import pytest

from canwire import BadTiming, BusOff, CanwireError, Unplugged
from canwire.hub.protocol.failure import failed, raised, serial_in
from canwire.hub.protocol.messages import Failed


@pytest.mark.parametrize(
    "error",
    [CanwireError("no"), BadTiming("a timing"), Unplugged("it was pulled out"), BusOff("can0: off the bus")],
)
def test_an_error_arrives_as_what_it_was_with_its_text(error: CanwireError) -> None:
    came = raised(failed(error))
    assert (type(came), str(came)) == (type(error), str(error))


@pytest.mark.parametrize("name", ["", "Newer", "ValueError", "annotations", "__doc__"])
def test_an_error_that_is_unknown_here_is_one_all_the_same(name: str) -> None:
    came = raised(Failed(name, "its text"))
    assert (type(came), str(came)) == (CanwireError, "its text")


@pytest.mark.parametrize(
    ("payload", "serial"),
    [
        (msgspec.msgpack.encode((7, ["Nonsense"])), 7),
        (msgspec.msgpack.encode((1, None)), 1),
        (msgspec.msgpack.encode((0, None)), 0),
        (msgspec.msgpack.encode((-1, None)), 0),  # a program's serials begin with 1
        (msgspec.msgpack.encode((1 << 63, None)), 1 << 63),
        (msgspec.msgpack.encode(("7", None)), 0),
        (msgspec.msgpack.encode((7, None, None)), 0),
        (msgspec.msgpack.encode(7), 0),
        (b"", 0),
        (b"\xc1", 0),
        (b"\x92\x07", 0),
        (b"\x92\x07" + b"\x91" * 100_000, 0),
    ],
    ids=lambda value: "" if isinstance(value, bytes) else None,
)
def test_the_serial_of_what_is_no_request_is_0_unless_it_can_be_told(payload: bytes, serial: int) -> None:
    assert serial_in(payload) == serial
