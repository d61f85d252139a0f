"""A call and its answer on the network: the messages of the hub, and the positions of the rings at that moment.

A request is carried out after everything that the client sent before it, and only once even if it arrives several
times. The program gets an answer after everything that its queues held when the hub answered. So a link behaves like
shared memory.
"""

from __future__ import annotations

import msgspec

from canwire.errors import BadMessage, CanwireError
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.failure import failed, serial_in
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.message import Message
from canwire.hub.protocol.pending import Pending

Positions = tuple[tuple[int, int], ...]
States = tuple[tuple[int, int, int], ...]


class Asked(msgspec.Struct, array_like=True, forbid_unknown_fields=True):
    """`oldest` is the lowest serial that the client still wants an answer to; `host` is where it runs.

    `stamp` is when it was said (cuts/age.py). `rings` is how a program that keeps one time has left its own:
    number, records taken, the position it waits for.
    """

    serial: int
    oldest: int
    host: str
    positions: Positions
    request: bytes
    rings: States = ()
    stamp: int = 0


class Answered(msgspec.Struct, array_like=True, forbid_unknown_fields=True):
    """`rings`: numbers of those that the reply opened, and how many records are in each already.

    `taken`: what the hub has taken from the rings of a program that keeps one time. `clock_ns`: the hub's.
    """

    reply: bytes
    rings: Positions
    positions: Positions
    taken: Positions = ()
    clock_ns: int = 0


_encoder = msgspec.msgpack.Encoder()
_asked = msgspec.msgpack.Decoder(Asked)
_answered = msgspec.msgpack.Decoder(Answered)


def encode(message: Asked | Answered) -> bytes:
    return _encoder.encode(message)


def asked_in(payload: bytes) -> Asked:
    """Raises BadMessage."""
    try:
        return _asked.decode(payload)
    except (msgspec.MsgspecError, ValueError) as error:
        raise BadMessage(f"a call of {len(payload)} bytes: {error}") from None


def answered_in(payload: bytes) -> Answered:
    """Raises BadMessage."""
    try:
        return _answered.decode(payload)
    except (msgspec.MsgspecError, ValueError) as error:
        raise BadMessage(f"an answer of {len(payload)} bytes: {error}") from None


def refused(payload: bytes, error: CanwireError) -> bytes:
    """The answer to a call that is not carried out."""
    try:
        serial = serial_in(asked_in(payload).request)
    except BadMessage:
        serial = 0
    return encode(Answered(m.encode_reply(serial, failed(error))[m.LENGTH.size :], (), ()))


class Call:
    """A client's call on its way."""

    def __init__(self, request: Message, payload: bytes) -> None:
        self.request = request
        self.payload = payload
        self.answered: Pending[tuple[Answer, Answered]] = Pending()
