"""Master requests of a schedule's configuration commands.

Source: reference/lin-protocol.md section 10; ldfparser 0.26.
"""

from __future__ import annotations

from typing import Any

from canwire.errors import BadDescription
from canwire.values.lin.frame import protected_id


def command(kind: str, entry: Any) -> bytes:
    """Return the data of the request; `entry` is one of ldfparser's, `kind` the name of its class.

    Raises BadDescription if the file does not contain the data that the request needs.
    """
    nad: int = entry.node.configured_nad if hasattr(entry, "node") else 0
    if kind == "FreeFormatEntry":
        return bytes(entry.data).ljust(8, b"\xff")
    if kind == "AssignNadEntry":
        product = entry.node.product_id
        ids = product.supplier_id.to_bytes(2, "little") + product.function_id.to_bytes(2, "little")
        return bytes([entry.node.initial_nad, 6, 0xB0]) + ids + bytes([nad])
    if kind == "ConditionalChangeNadEntry":
        return bytes([entry.nad, 6, 0xB3, entry.id, entry.byte, entry.mask, entry.inv, entry.new_nad])
    if kind == "DataDumpEntry":
        return bytes([nad, 6, 0xB4, *entry.data])
    if kind == "SaveConfigurationEntry":
        return bytes([nad, 1, 0xB6]).ljust(8, b"\xff")
    if kind == "AssignFrameIdRangeEntry":
        pids = _pids(entry)
        return bytes([nad, 6, 0xB7, entry.frame_index, *pids])
    return _assign_frame_id(kind, entry, nad)


def _pids(entry: Any) -> list[int]:
    """Return the entry's protected identifiers; if it has none, those that the file gives the frames."""
    if entry.pids:
        return [*entry.pids, *[0xFF] * 4][:4]
    frames = entry.node.configurable_frames
    indices = range(entry.frame_index, entry.frame_index + 4)
    return [protected_id(frames[k].frame_id) if k in frames else 0xFF for k in indices]


def _assign_frame_id(kind: str, entry: Any, nad: int) -> bytes:
    """Return LIN 2.0's command: supplier, message id, and the protected identifier to assign (0x40: none)."""
    frames = {frame.name: number for number, frame in entry.node.configurable_frames.items()}
    message = frames.get(entry.frame.name)
    if (
        message is None or str(entry.node.lin_protocol) != "2.0"
    ):  # later ones count frames, and have no such command
        raise BadDescription(
            f"AssignFrameId: {entry.node.name} has no message identifier for {entry.frame.name} in the file"
        )
    pid = protected_id(entry.frame.frame_id) if kind == "AssignFrameIdEntry" else 0x40
    supplier = entry.node.product_id.supplier_id.to_bytes(2, "little")
    return bytes([nad, 6, 0xB1]) + supplier + message.to_bytes(2, "little") + bytes([pid])
