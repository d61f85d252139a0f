"""Which bit of a frame to invert, for a named place or to provoke a kind of error."""

from __future__ import annotations

from canwire.bus.can.bit_layout import BitLayout

PLACES = {
    "ack": "ACK",
    "crc delimiter": "CRC DEL",
    "ack delimiter": "ACK DEL",
    "eof": "EOF",
    "dlc": "DLC",
    "data": "DATA",
}
INJECTED = ("stuff", "form", "crc", "bit", "ack")


def place(layout: BitLayout, name: str) -> int:
    """The index of the bit to invert for a named place or error; -1 if this frame has no such bit."""
    if name in PLACES:
        return layout.find(PLACES[name])
    if name == "stuff":
        return stuff_error_bit(layout)
    if name == "form":
        return layout.find("CRC DEL")
    if name == "ack":
        return layout.ack_slot()
    if name == "bit":
        return next(k for k in range(layout.find("DLC"), len(layout.levels)) if layout.levels[k] == 0)
    return quiet_crc_bit(layout)


def stuff_error_bit(layout: BitLayout) -> int:
    """A bit whose inversion makes six equal bits: a stuff bit, or one that breaks up a long run."""
    fixed = layout.first_fixed_stuff_bit()
    levels = layout.levels[: fixed if fixed >= 0 else layout.find("CRC DEL")]
    for k in range(len(levels)):
        if layout.stuffed[k]:
            return k
    for k in range(1, len(levels)):
        changed = bytearray(levels)
        changed[k] ^= 1
        if -1 in stuff_positions(changed):
            return k
    return -1


def quiet_crc_bit(layout: BitLayout) -> int:
    """A CRC bit whose inversion changes no stuffing, so that only the check value is wrong."""
    start, end = layout.find("CRC"), layout.find("CRC DEL")
    fixed = layout.first_fixed_stuff_bit() >= 0
    before = stuff_positions(layout.levels[:end])
    for k in range(end - 1, start - 1, -1):
        if layout.stuffed[k]:
            continue
        changed = bytearray(layout.levels[:end])
        changed[k] ^= 1
        if (fixed and not layout.stuffed[k + 1]) or (not fixed and stuff_positions(changed) == before):
            return k
    return -1


def stuff_positions(levels: bytes | bytearray) -> list[int]:
    """The indices, from SOF on, at which a receiver expects stuff bits; -1 for a bit that violates the stuff rule."""
    positions = []
    run = 0
    for k, level in enumerate(levels):
        if run == 5:
            positions.append(k if level != levels[k - 1] else -1)
            run = 1
        else:
            run = run + 1 if k and level == levels[k - 1] else 1
    return [*positions, -2] if run == 5 else positions
