"""Bits of frames against the vectors of can-protocol.md and a slow reference, level by level."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.bus.can.bit_layout import FIELDS, BitLayout, crc_of
from canwire.bus.can.bits import CRC15_POLY, CRC17_POLY, CRC21_POLY, NON_ISO, measure
from canwire.bus.can.node import ISO_FD, Mailbox
from canwire.values.frame import Frame, record_of_frame
from tests.bus.can import reference_bits
from tests.cases import each
from tests.tables import frame_vectors
from tests.tables.frame_vectors import STREAMS, VECTORS, Vector

pytestmark = pytest.mark.core

INTERMISSION = 3

by_name = pytest.mark.parametrize("vector", VECTORS, ids=lambda vector: vector.name)
fd_by_name = pytest.mark.parametrize("vector", frame_vectors.FD, ids=lambda vector: vector.name)


def measured(frame: Frame, fd_mode: int = ISO_FD) -> Mailbox:
    box = Mailbox()
    box.block[:] = record_of_frame(frame)
    measure(box, fd_mode)
    return box


def length_of(frame: Frame) -> int:
    return int(measured(frame).bits)


def levels_of(layout: BitLayout) -> str:
    return "".join(map(str, layout.levels))


def frame_of(vector: Vector) -> Frame:
    return Frame(vector.id, vector.data, **vector.keywords)


def reference_of(frame: Frame, *, iso: bool = True) -> reference_bits.Reference:
    if frame.fd:
        return reference_bits.flexible(
            frame.id,
            extended=frame.extended,
            switch=frame.bit_rate_switch,
            passive=frame.error_state_indicator,
            dlc=frame.dlc,
            data=frame.data,
            iso=iso,
        )
    return reference_bits.classic(
        frame.id, extended=frame.extended, remote=frame.remote, dlc=frame.dlc, data=frame.data
    )


# half of all random data runs long in equal bits, or else there would be little to stuff
long_runs = st.lists(st.sampled_from(b"\x00\xff\xf0\x0f\x1f\xe0\x3c"), min_size=64, max_size=64).map(bytes)
payloads = st.one_of(st.binary(min_size=64, max_size=64), long_runs)
near_misses = st.sampled_from([0, 0x7FF, 0x7F0, 0x00F, 0x3E0, 0x41F, 0x078])


@st.composite
def identifiers(draw: st.DrawFn) -> tuple[int, bool]:
    if draw(st.booleans()):
        base = draw(near_misses | st.integers(0, 0x7FF))
        return base << 18 | draw(st.sampled_from([0, 0x3FFFF, 0x1F]) | st.integers(0, 0x3FFFF)), True
    return draw(near_misses | st.integers(0, 0x7FF)), False


@st.composite
def classic_frames(draw: st.DrawFn) -> Frame:
    id, extended = draw(identifiers())
    dlc, remote = draw(st.integers(0, 15)), draw(st.booleans())
    data = b"" if remote else draw(payloads)[: min(dlc, 8)]
    return Frame(id, data, extended=extended, remote=remote, dlc=dlc)


@st.composite
def fd_frames(draw: st.DrawFn) -> Frame:
    id, extended = draw(identifiers())
    dlc = draw(st.integers(0, 15))
    return Frame(
        id,
        draw(payloads)[: reference_bits.FD_LENGTH[dlc]],
        extended=extended,
        fd=True,
        bit_rate_switch=draw(st.booleans()),
        error_state_indicator=draw(st.booleans()),
    )


frames = st.one_of(classic_frames(), fd_frames())


class TestVectors:
    def test_the_table_is_whole(self) -> None:
        assert [vector.name for vector in VECTORS] == [
            *(f"C{k:02}" for k in range(1, 33)),
            *(f"D{k:02}" for k in range(1, 17)),
        ]
        assert list(STREAMS) == ["C01", "C04", "C17", "C20", "D01", "D03", "D14"]

    @by_name
    def test_the_reference_agrees(self, vector: Vector) -> None:
        reference = reference_of(frame_of(vector))
        assert (reference.crc, reference.stuff_bits, len(reference.bits)) == (
            vector.crc,
            vector.stuff_bits,
            vector.bits,
        )
        assert (reference.stuff_count, reference.data_bits) == (vector.stuff_count, vector.data_bits)

    @pytest.mark.conforms("G-06")
    @by_name
    def test_measured_length(self, vector: Vector) -> None:
        box = measured(frame_of(vector))
        assert (box.bits, box.data_bits) == (vector.bits, vector.data_bits)

    @pytest.mark.conforms("G-06")
    @by_name
    def test_laid_out(self, vector: Vector) -> None:
        layout = BitLayout(frame_of(vector))
        found = (layout.crc, layout.stuff_bits, len(layout.levels), layout.data_bits)
        assert found == (vector.crc, vector.stuff_bits, vector.bits, vector.data_bits)

    @each("name", STREAMS)
    def test_every_bit(self, name: str) -> None:
        frame = frame_of(next(vector for vector in VECTORS if vector.name == name))
        layout = BitLayout(frame)
        layout.levels[layout.ack_slot()] = 0
        assert levels_of(layout) == STREAMS[name]

    @fd_by_name
    def test_stuff_count_and_parity(self, vector: Vector) -> None:
        layout = BitLayout(frame_of(vector))
        start = layout.find("STUFF COUNT")
        assert levels_of(layout)[start : start + 4] == vector.stuff_count

    @fd_by_name
    def test_non_iso(self, vector: Vector) -> None:
        frame = frame_of(vector)
        layout, box = BitLayout(frame, fd_mode=NON_ISO), measured(frame, NON_ISO)
        assert (layout.crc, len(layout.levels), box.bits) == (
            vector.non_iso_crc,
            vector.bits - 5,
            vector.bits - 5,
        )

    @pytest.mark.parametrize(("id", "extended", "data", "bits"), frame_vectors.LONGEST)
    def test_longest_frames_known(self, id: int, extended: bool, data: bytes, bits: int) -> None:
        assert length_of(Frame(id, data, extended=extended)) == bits


class TestAgainstReference:
    @given(frames)
    def test_measured_length(self, frame: Frame) -> None:
        reference, box = reference_of(frame), measured(frame)
        assert (box.bits, box.data_bits) == (len(reference.bits), reference.data_bits)

    @given(fd_frames())
    def test_measured_length_non_iso(self, frame: Frame) -> None:
        reference, box = reference_of(frame, iso=False), measured(frame, NON_ISO)
        assert (box.bits, box.data_bits) == (len(reference.bits), reference.data_bits)

    @given(frames, st.booleans())
    def test_every_level(self, frame: Frame, iso: bool) -> None:
        reference = reference_of(frame, iso=iso)
        layout = BitLayout(frame, fd_mode=ISO_FD if iso else NON_ISO)
        assert levels_of(layout) == reference.bits
        assert (layout.crc, layout.stuff_bits, layout.data_bits) == (
            reference.crc,
            reference.stuff_bits,
            reference.data_bits,
        )

    @given(frames)
    def test_fields_cover_every_bit(self, frame: Frame) -> None:
        layout = BitLayout(frame)
        names = [FIELDS[index] for index in layout.fields]
        plain = [name for name, stuffed in zip(names, layout.stuffed, strict=True) if not stuffed]
        crc = 15 if not frame.fd else 17 if len(frame.data) <= 16 else 21
        widths = {"SOF": 1, "ID": 11, "DLC": 4, "DATA": 8 * len(frame.data), "CRC": crc, "ACK": 1, "EOF": 7}
        assert {name: plain.count(name) for name in widths} == widths
        assert plain.count("EXT") == (18 if frame.extended else 0)
        assert plain.count("STUFF COUNT") == (4 if frame.fd else 0)
        assert layout.ack_slot() == len(names) - 9
        fixed = ({17: 6, 21: 7}[crc]) if frame.fd else 0
        assert sum(layout.stuffed) == layout.stuff_bits + fixed
        fixed_from = layout.first_fixed_stuff_bit()
        assert fixed_from == (layout.find("STUFF COUNT") - 1 if frame.fd else -1)

    @given(fd_frames())
    def test_an_error_passive_sender_shows_it(self, frame: Frame) -> None:
        shown = Frame(
            frame.id,
            frame.data,
            extended=frame.extended,
            fd=True,
            bit_rate_switch=frame.bit_rate_switch,
            error_state_indicator=True,
        )
        assert BitLayout(frame, error_passive=True).levels == BitLayout(shown).levels

    @given(classic_frames())
    def test_a_classic_frame_shows_no_error_state(self, frame: Frame) -> None:
        assert BitLayout(frame, error_passive=True).levels == BitLayout(frame).levels

    @given(classic_frames())
    def test_fd_mode_means_nothing_to_classic_frames(self, frame: Frame) -> None:
        assert measured(frame, NON_ISO).bits == measured(frame).bits == measured(frame, 0).bits


class TestArbitrationKey:
    """Section 6: the lowest key wins."""

    @pytest.mark.conforms("G-04")
    @given(frames, frames)
    def test_orders_as_the_wire_does(self, one: Frame, other: Frame) -> None:
        self.check(one, other)

    @pytest.mark.conforms("G-04")
    @given(st.data(), st.integers(0, 0x7FF))
    def test_same_base_identifier(self, data: st.DataObject, base: int) -> None:
        self.check(data.draw(self.rivals(base)), data.draw(self.rivals(base)))

    @pytest.mark.conforms("G-04")
    def test_precedence_of_formats(self) -> None:
        base = 0x123
        in_order = [
            Frame(base),
            Frame(base, remote=True),
            Frame(base << 18, extended=True),
            Frame(base << 18, extended=True, remote=True),
            Frame(base << 18 | 1, extended=True),
            Frame(base + 1),
        ]
        keys = [measured(frame).key for frame in in_order]
        assert keys == sorted(set(keys))

    def test_fd_and_classic_frames_of_one_identifier_do_not_differ(self) -> None:
        assert measured(Frame(0x123, fd=True)).key == measured(Frame(0x123, b"\x01")).key

    def rivals(self, base: int) -> st.SearchStrategy[Frame]:
        extensions = st.sampled_from([0, 1, 0x20000, 0x3FFFF])
        extended = st.builds(
            lambda low, remote: Frame(base << 18 | low, extended=True, remote=remote),
            extensions,
            st.booleans(),
        )
        return st.one_of(st.builds(lambda remote: Frame(base, remote=remote), st.booleans()), extended)

    def check(self, one: Frame, other: Frame) -> None:
        a, b = measured(one).key, measured(other).key
        verdict = reference_bits.wins(reference_of(one).arbitration, reference_of(other).arbitration)
        assert verdict == (None if a == b else a < b)


@pytest.mark.conforms("G-06")
class TestFrameRates:
    """Section 9: bits of a frame and its intermission."""

    def test_shortest_of_all_empty_standard_frames(self) -> None:
        lengths = [length_of(Frame(id)) + INTERMISSION for id in range(0x800)]
        assert min(lengths) == frame_vectors.BEST_BITS["SFF0"]
        assert length_of(Frame(0x084)) + INTERMISSION == min(lengths)

    @given(identifiers(), payloads)
    def test_bounds_of_eight_bytes(self, identifier: tuple[int, bool], payload: bytes) -> None:
        id, extended = identifier
        column = "EFF8" if extended else "SFF8"
        bits = length_of(Frame(id, payload[:8], extended=extended)) + INTERMISSION
        assert frame_vectors.BEST_BITS[column] <= bits <= frame_vectors.WORST_BITS[column]

    def test_the_best_is_reached(self) -> None:
        assert length_of(Frame(0x2AA, b"\xaa" * 8)) + INTERMISSION == frame_vectors.BEST_BITS["SFF8"]
        assert (
            length_of(Frame(0x15555555, b"\x55" * 8, extended=True)) + INTERMISSION
            == frame_vectors.BEST_BITS["EFF8"]
        )

    @each("kilobits", frame_vectors.FRAME_RATES)
    def test_frames_a_second(self, kilobits: int) -> None:
        best, worst = frame_vectors.BEST_BITS, frame_vectors.WORST_BITS
        bits = (best["SFF0"], best["SFF8"], worst["SFF8"], best["EFF8"], worst["EFF8"])
        assert frame_vectors.FRAME_RATES[kilobits] == tuple(kilobits * 1000 // count for count in bits)


@each(
    ("polynomial", "width", "check"),
    [(CRC15_POLY, 15, 0x059E), (CRC17_POLY, 17, 0x04F03), (CRC21_POLY, 21, 0x0ED841)],
)
def test_crc_check_values(polynomial: int, width: int, check: int) -> None:
    bits = [byte >> k & 1 for byte in b"123456789" for k in range(7, -1, -1)]
    assert crc_of(bits, polynomial, width, 0) == check
    full = getattr(reference_bits, f"CRC_{width}")
    assert int(full, 2) == 1 << width | polynomial
    assert int(reference_bits.remainder("".join(map(str, bits)), full, "0" * width), 2) == check
