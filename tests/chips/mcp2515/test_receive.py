"""What the MCP2515 keeps: filters and masks, its two receive buffers, roll-over, overflows, FILHIT."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from tests.cases import each
from tests.chips.mcp2515 import bench
from tests.effort import examples
from tests.tables import mcp2515_vectors as table

pytestmark = pytest.mark.core


RX0, RX1 = m.INT_RX
STANDARD = Frame(0x123, b"\x11\x22\x33")
EXTENDED = Frame(0x12345678, b"\x44" * 8, extended=True)


def put(chip: Mcp2515, address: int, octets: str) -> None:
    for place, octet in enumerate(bytes.fromhex(octets)):
        chip.write(address + place, octet)


def receiver(
    modes: tuple[int, int] = (m.RXM_ALL, m.RXM_ALL), *, bukt: bool = False, **patterns: str
) -> Mcp2515:
    """A chip in normal mode without a bus; `patterns` are four bytes each, by RXF0 and so on."""
    chip = Mcp2515()
    for name, octets in patterns.items():
        put(chip, m.MAP.named(f"{name}SIDH").address, octets)
    chip.write(m.RXBCTRL[0], modes[0] << m.RX_RXM_SHIFT | (m.RX_BUKT if bukt else 0))
    chip.write(m.RXBCTRL[1], modes[1] << m.RX_RXM_SHIFT)
    chip.write(m.CANINTE, 0xFF)
    chip.write(m.CANCTRL, 0)
    return chip


def full(chip: Mcp2515) -> int:
    return chip.read(m.CANINTF) & (RX0 | RX1)


@each(("mask", "pattern", "mode", "id", "remote", "data", "accepted"), table.FILTERS)
@each("number", range(6))
def test_filter_vectors(
    number: int, mask: str, pattern: str, mode: int, id: str, remote: bool, data: str, accepted: bool
) -> None:
    """Each row through each filter, all the others letting nothing through that the row could send."""
    buffer = 0 if number < 2 else 1
    frame = Frame(int(id, 16), bytes.fromhex(data), extended=len(id) == 8, remote=remote)
    nothing = f"{bytes([0xFF, 0xE0 | 0x08 * (not frame.extended), 0xFF, 0xFF]).hex()}"
    patterns = {f"RXF{k}": nothing for k in range(6)}
    patterns |= {"RXM0": "FFE3FFFF", "RXM1": "FFE3FFFF", f"RXM{buffer}": mask, f"RXF{number}": pattern}
    modes = (mode, m.RXM_FILTERS) if buffer == 0 else (m.RXM_FILTERS, mode)
    chip = receiver(modes, bukt=False, **patterns)
    bench.deliver(chip, frame)
    assert full(chip) == (m.INT_RX[buffer] if accepted else 0)
    if accepted:
        first = mode == m.RXM_ALL
        hit = chip.read(m.RXBCTRL[buffer]) & (m.RX_FILHIT if buffer else m.RX_FILHIT0)
        assert hit == ((0, 2)[buffer] if first else number)
        assert bool(chip.read(m.RXBCTRL[buffer]) & m.RX_RXRTR) == remote
        assert bench.frame_of(chip.read_buffer(buffer)) == frame


IDS = st.one_of(
    st.tuples(st.integers(0, 0x7FF), st.just(False)), st.tuples(st.integers(0, 0x1FFFFFFF), st.just(True))
)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    id, extended = draw(IDS)
    if draw(st.booleans()):
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 8)))
    return Frame(id, draw(st.binary(max_size=8)), extended=extended)


def bits_of(frame: Frame) -> dict[str, int]:
    """A frame's bits by the names of those that filters have for them; what it does not have is not there."""
    if frame.extended:
        named = {f"SID{k}": frame.id >> 18 + k & 1 for k in range(11)}
        return named | {f"EID{k}": frame.id >> k & 1 for k in range(18)}
    named = {f"SID{k}": frame.id >> k & 1 for k in range(11)}
    if not frame.remote:
        for place, octet in enumerate(frame.data[:2]):
            named |= {f"EID{8 * (1 - place) + k}": octet >> k & 1 for k in range(8)}
    return named


def bits_in(octets: bytes) -> dict[str, int]:
    """The bits of a filter or mask by the names in registers 4-10 to 4-17."""
    high, low, eid8, eid0 = octets
    names = {f"SID{3 + k}": high >> k & 1 for k in range(8)} | {f"SID{k}": low >> 5 + k & 1 for k in range(3)}
    names |= {f"EID{16 + k}": low >> k & 1 for k in range(2)}
    return (
        names
        | {f"EID{8 + k}": eid8 >> k & 1 for k in range(8)}
        | {f"EID{k}": eid0 >> k & 1 for k in range(8)}
    )


@examples(100)
@given(
    frames(), st.lists(st.binary(min_size=4, max_size=4), min_size=6, max_size=6),
    st.lists(st.binary(min_size=4, max_size=4), min_size=2, max_size=2),
    st.sampled_from([0x00, 0x80, 0xF0, 0xFF]), st.booleans(),
)  # fmt: skip
def test_filters_bit_by_bit(
    frame: Frame, filters: list[bytes], masks: list[bytes], care: int, near: bool
) -> None:
    """Against table 4-2, with masks thinned out so that some pass; `near`: the filters are the frame itself."""
    masks = [bytes(octet & care for octet in mask) for mask in masks]
    if near:
        filters[3] = bytes([*bench.octets_of(frame)[:2], *(frame.data + bytes(2))[:2]])
    patterns = {f"RXF{k}": octets.hex() for k, octets in enumerate(filters)}
    patterns |= {f"RXM{k}": octets.hex() for k, octets in enumerate(masks)}
    chip = receiver((m.RXM_FILTERS, m.RXM_FILTERS), bukt=False, **patterns)
    bench.deliver(chip, frame)
    there = bits_of(frame)
    expected = 0
    for number, octets in enumerate(filters):
        wanted, compared = bits_in(octets), bits_in(masks[number > 1])
        if bool(octets[1] & 0x08) is frame.extended and all(
            not compared[name] or wanted[name] == bit for name, bit in there.items()
        ):
            expected = m.INT_RX[number > 1]
            hit = chip.read(m.RXBCTRL[number > 1]) & (m.RX_FILHIT if number > 1 else m.RX_FILHIT0)
            assert hit == number
            break
    assert full(chip) == expected


@each("frame", [STANDARD, EXTENDED, Frame(0x7FF, remote=True, dlc=5),
                                   Frame(0x1FFFFFFF, extended=True, remote=True, dlc=8), Frame(0, b"")])  # fmt: skip
def test_a_frame_in_a_buffer(frame: Frame) -> None:
    chip = receiver()
    bench.deliver(chip, frame)
    at = m.RXBCTRL[0]
    assert bool(chip.read(at + m.SIDL) & 0x08) == frame.extended
    assert bool(chip.read(at + m.SIDL) & 0x10) == (frame.remote and not frame.extended)
    assert bool(chip.read(at + m.DLC) & 0x40) == (frame.remote and frame.extended)
    assert chip.read(at + m.DLC) & 15 == frame.dlc
    assert bench.frame_of(chip.read_buffer(0)) == frame
    assert full(chip) == 0


def test_without_roll_over_the_second_frame_is_lost() -> None:
    chip = receiver()
    for number in range(3):
        bench.deliver(chip, Frame(number, b""))
    assert (full(chip), chip.read(m.EFLG)) == (RX0, m.EFLG_RX0OVR)
    assert chip.read(m.CANINTF) & m.INT_ERR
    assert bench.frame_of(chip.read_buffer(0)).id == 0


def test_with_roll_over_the_third_frame_is_lost() -> None:
    chip = receiver(bukt=True)
    assert chip.read(m.RXBCTRL[0]) & 0x06 == 0x06  # BUKT1 is a copy
    for number in range(3):
        bench.deliver(chip, Frame(number, b""))
    assert (full(chip), chip.read(m.EFLG)) == (RX0 | RX1, m.EFLG_RX1OVR)
    chip.modify(m.CANINTF, RX0, 0)
    assert chip.rx_status() == 0x80 | 6  # RXF0, rolled over
    assert [bench.frame_of(chip.read_buffer(number)).id for number in (0, 1)] == [0, 1]


def test_overflow_flags_stay_until_they_are_cleared() -> None:
    chip = receiver()
    for number in range(2):
        bench.deliver(chip, Frame(number, b""))
    chip.read_buffer(0)
    bench.deliver(chip, Frame(5, b""))
    assert (full(chip), chip.read(m.EFLG)) == (RX0, m.EFLG_RX0OVR)
    chip.write(m.EFLG, 0)
    assert chip.read(m.EFLG) == 0


def test_a_frame_for_the_first_buffer_never_goes_to_the_second_without_roll_over() -> None:
    chip = receiver((m.RXM_FILTERS, m.RXM_FILTERS))  # masks of 0: every standard frame, by RXF0
    bench.deliver(chip, STANDARD)
    bench.deliver(chip, STANDARD)
    assert (full(chip), chip.read(m.EFLG)) == (RX0, m.EFLG_RX0OVR)


def test_each_buffer_has_its_own_frames() -> None:
    only = {
        "RXM0": "FFE00000",
        "RXF0": "24600000",
        "RXF1": "24800000",
        "RXM1": "FFE00000",
        "RXF3": "24A00000",
    }
    chip = receiver((m.RXM_FILTERS, m.RXM_FILTERS), bukt=True, **only)
    for id in (0x125, 0x126, 0x124):
        bench.deliver(chip, Frame(id, b""))
    assert (full(chip), chip.read(m.EFLG)) == (RX0 | RX1, 0)
    assert (chip.read(m.RXBCTRL[0]) & 1, chip.read(m.RXBCTRL[1]) & 7) == (1, 3)
    bench.deliver(chip, Frame(0x125, b""))
    assert chip.read(m.EFLG) == m.EFLG_RX1OVR
    chip.read_buffer(1)
    bench.deliver(chip, Frame(0x123, b""))  # RXB0 is full: over into RXB1
    assert (full(chip), chip.read(m.RXBCTRL[0]) & 1, chip.read(m.RXBCTRL[1]) & 7) == (RX0 | RX1, 0, 0)
