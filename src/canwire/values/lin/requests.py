"""Requests of a master for node configuration and identification, and the text of negative answers.

Source: LIN 2.2A 4.2; reference/lin-protocol.md section 10.
"""

from __future__ import annotations

from collections.abc import Sequence

from canwire.errors import BadValue
from canwire.values.checks import whole
from canwire.values.lin.configuration import (
    ASSIGN_FRAME_ID_RANGE,
    ASSIGN_NAD,
    READ_BY_IDENTIFIER,
    SAVE_CONFIGURATION,
)
from canwire.values.lin.frame import protected_id

_ANY_SUPPLIER, _ANY_FUNCTION = 0x7FFF, 0xFFFF
_UNCHANGED = -1
_RANGE = 4
_UNASSIGNED, _KEPT = 0x00, 0xFF
_NEGATIVE, _RESPONSE = 0x7F, 0x40
_REASONS = {0x12: "it does not have that", 0x11: "it does not know this service"}


def read_by_identifier_request(
    id: int = 0, supplier: int = _ANY_SUPPLIER, function: int = _ANY_FUNCTION
) -> bytes:
    """Read the product (`id` 0), the serial number (1), or values of the supplier (32 to 63). Raises BadValue."""
    return bytes([READ_BY_IDENTIFIER, whole("id", id, 0, 63), *_product(supplier, function)])


def assign_nad_request(nad: int, supplier: int = _ANY_SUPPLIER, function: int = _ANY_FUNCTION) -> bytes:
    """Assign this NAD; sent to the initial NAD of the node of that supplier and function. Raises BadValue."""
    return bytes([ASSIGN_NAD, *_product(supplier, function), whole("nad", nad, 0x01, 0xFF)])


def assign_frame_ids_request(first: int, ids: Sequence[int | None]) -> bytes:
    """Identifiers for up to four frames from index `first` on; -1 keeps one, None takes it away. Raises BadValue."""
    whole("first", first, 0, 0xFF)
    if not 1 <= len(ids) <= _RANGE:
        raise BadValue(f"{len(ids)} identifiers: 1 to {_RANGE} in one request")
    pids = [_UNASSIGNED if id is None else _KEPT if id == _UNCHANGED else protected_id(id) for id in ids]
    return bytes([ASSIGN_FRAME_ID_RANGE, first, *pids, *[_KEPT] * (_RANGE - len(pids))])


def save_configuration_request() -> bytes:
    """Save NAD and identifiers for the next power-up."""
    return bytes([SAVE_CONFIGURATION])


def lin_refusal(answer: bytes) -> str:
    """The reason in a negative response as text; "" for a positive response."""
    if answer[:1] != bytes([_NEGATIVE]):
        return ""
    code = answer[2] if len(answer) > 2 else 0
    service = f"service {answer[1]:#04x}" if len(answer) > 1 else "the request"
    return f"it refuses {service}: {_REASONS.get(code, 'code')} ({code:#04x})"


def _product(supplier: int, function: int) -> bytes:
    whole("supplier", supplier, 0, _ANY_SUPPLIER)
    whole("function", function, 0, _ANY_FUNCTION)
    return supplier.to_bytes(2, "little") + function.to_bytes(2, "little")
