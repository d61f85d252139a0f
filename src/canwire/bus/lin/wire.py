"""The state that the nodes of a LIN bus share besides its level, and the fields of each header and response."""

from __future__ import annotations

from typing import NamedTuple

from canwire.bus.lin.bits import Field, header_fields, response_fields
from canwire.bus.lin.node import LinNode, LinResponse
from canwire.values.lin.frame import protected_id

NO_RESPONSE = -1


class Outgoing(NamedTuple):
    """Fields to be sent, and the bits (field, bit) of them that noise inverts for all nodes."""

    fields: list[Field]
    flips: frozenset[tuple[int, int]] = frozenset()


class LinTap:
    """Receives every successful response, with its sender."""

    def transmitted(self, node: LinNode, response: LinResponse, at_ns: int) -> None:
        raise NotImplementedError


class LinDisturber:
    """Disturbs headers and responses."""

    def concerns(self, id: int) -> bool:
        """Whether the next frame with this identifier is to be disturbed."""
        raise NotImplementedError

    def header(self, node: LinNode, id: int) -> Outgoing:
        """The fields to send for this node's header."""
        raise NotImplementedError

    def response(self, response: LinResponse) -> Outgoing | None:
        """The fields to send for this response; None: nothing."""
        raise NotImplementedError


class Wire:
    """`planned` is the number of data bytes of the current response, NO_RESPONSE before it begins.

    The wire does not show a frame's length; nodes without a configured length use this number.
    """

    def __init__(self) -> None:
        self.planned = NO_RESPONSE
        self.frames = 0
        self.tap: LinTap | None = None
        self.disturber: LinDisturber | None = None

    def header(self, node: LinNode, id: int) -> Outgoing:
        """The fields that this node sends for its header, disturbed if a fault concerns it."""
        self.planned = NO_RESPONSE
        disturber = self.disturber
        if disturber is not None and disturber.concerns(id):
            return disturber.header(node, id)
        return plain_header(node, id)

    def response(self, response: LinResponse) -> Outgoing | None:
        """The fields to send for this response, disturbed if a fault concerns it; None: nothing."""
        disturber = self.disturber
        disturbed = disturber is not None and disturber.concerns(response.id)
        going_out = disturber.response(response) if disturber is not None and disturbed else plain(response)
        if going_out is not None:
            self.planned = max(self.planned, response.length)
        return going_out

    def transmitted(self, node: LinNode, response: LinResponse, at_ns: int) -> None:
        """Count a response that was transmitted, and report it to the tap."""
        self.frames += 1
        if self.tap is not None:
            self.tap.transmitted(node, response, at_ns)


def plain_header(node: LinNode, id: int) -> Outgoing:
    """An undisturbed header with the node's settings."""
    fields = header_fields(
        protected_id(id),
        break_bits=node.break_bits,
        delimiter_bits=node.delimiter_bits,
        space_bits=node.space_bits,
    )
    return Outgoing(fields)


def plain(response: LinResponse) -> Outgoing:
    """An undisturbed response."""
    fields = response_fields(response.octets, space_bits=response.space_bits, gap_bits=response.gap_bits)
    return Outgoing(fields)
