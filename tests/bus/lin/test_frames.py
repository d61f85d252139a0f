"""LIN frames on the wire: their levels, their times to the nanosecond, what slaves accept, silence."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Lab, LabLinBus, LinErrorKind, LinEventKind, LinFrame
from canwire.bus.lin.bits import frame_levels, last_edge_bits
from canwire.values.lin.timing import bit_time_ps, nominal_frame_ns
from tests.cases import each
from tests.tables import lin_vectors

pytestmark = pytest.mark.core

DATA = bytes(range(1, 9))


def levels_of(bus: LabLinBus, bits: int, bit_ps: int) -> str:
    """What `bits` samples in the middle of bits show, from the moment this returns its function on."""
    changes = [(0, 1)]
    bus.wire.bits.capture = lambda at_ps, level: changes.append((at_ps, level))
    bus.wire.bitwise = True
    bus.time.run_until_idle()
    samples = ""
    for k in range(bits):
        at_ps = k * bit_ps + bit_ps // 2
        samples += str([level for when_ps, level in changes if when_ps <= at_ps][-1])
    return samples


@each(("id", "data", "stream"), lin_vectors.BIT_STREAMS)
def test_bit_streams_of_the_reference(id: int, data: str | None, stream: str) -> None:
    frame = LinFrame(id, header_only=True) if data is None else LinFrame(id, bytes.fromhex(data))
    assert "".join(map(str, frame_levels(frame))) == stream
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=19200)
        bus.slave()
        bus.master().send(frame)
        assert levels_of(bus, len(stream), bit_time_ps(19200)) == stream


def test_where_the_last_edge_of_a_byte_is() -> None:
    assert [last_edge_bits(value) for value in (0xFF, 0x00, 0x7F, 0xFE, 0x55)] == [1, 9, 9, 2, 9]


@each("rate", [1000, 2400, 9600, 10417, 19200, 20000])
@each("length", range(9))
def test_a_frame_takes_exactly_its_bits(rate: int, length: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=rate)
        slave = bus.slave(responses={0x10: DATA[:length]})
        master = bus.master()
        master.ask(0x10, length)
        lab.run_until_idle()
        frame = master.receive()
        assert frame == LinFrame(0x10, DATA[:length])
        assert frame is not None
        assert frame.timestamp_ns == nominal_frame_ns(rate, length)
        assert slave.receive() is None  # its own


def test_frames_go_back_to_back() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=19200)
        slave, master = bus.slave(), bus.master()
        for _ in range(160):
            master.send(LinFrame(0x10, DATA))
        lab.run_for(1.0)
        assert len(slave.receive_many(1000)) == 154
        assert bus.load == pytest.approx(100.0, abs=0.01)


def test_load() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=10_000)
        bus.slave(responses={1: b"\1\2"})
        bus.master(schedule=[(1, 0.0128)])
        lab.run_for(1.28)
        assert bus.load == pytest.approx(50.0, abs=0.6)
        assert bus.mean_load == pytest.approx(50.0, abs=0.01)
        assert bus.wire.busy_ns() == 100 * 6_400_000
        lab.run_for(0.0032)  # in the middle of a frame
        assert bus.wire.busy_ns() == 100 * 6_400_000 + 3_200_000


@each("bitwise", [False, True])
@each("length", [0, 1, 2, 8])
def test_an_absent_response_is_noticed_after_1_4_times_its_time(length: int, bitwise: bool) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.wire.bitwise = bitwise
        slave, master = bus.slave(), bus.master()
        master.events()
        slave.events()
        master.ask(0x22, length)
        lab.run_until_idle()
        (event,) = master.events(LinEventKind.ERROR)
        assert (event.error, event.id) == (LinErrorKind.SLNORE, 0x22)
        assert event.timestamp_ns == (34 + 14 * ((length or 8) + 1)) * 50_000
        assert slave.events(LinEventKind.ERROR) == []
        assert slave.counters.headers == 1


def test_a_subscriber_misses_its_frame_too() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave, other, master = bus.slave(subscribes={5: 2}), bus.slave("other"), bus.master()
        slave.events()
        other.events()
        master.ask(5, 8)
        lab.run_until_idle()
        (event,) = slave.events(LinEventKind.ERROR)
        assert (event.error, event.id, event.timestamp_ns) == (LinErrorKind.SLNORE, 5, (34 + 42) * 50_000)
        assert other.events(LinEventKind.ERROR) == []
        assert not slave.response_error


@each(
    ("break_bits", "delimiter_bits", "space_bits"),
    [(13, 1, 0), (26, 1, 0), (13, 10, 0), (13, 14, 0), (15, 3, 2), (19, 2, 6), (13, 1, 13)],
)
@each("bitwise", [False, True])
def test_headers_that_slaves_accept(
    break_bits: int, delimiter_bits: int, space_bits: int, bitwise: bool
) -> None:
    """PT-CT 5, 7 and 14."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.wire.bitwise = bitwise
        bus.slave(responses={0x10: b"\1"})
        master = bus.master(
            break_bits=break_bits, delimiter_bits=delimiter_bits, header_space_bits=space_bits
        )
        master.ask(0x10)
        frame = master.expect(0x10, within=0.1)
        header = break_bits + delimiter_bits + space_bits + 20
        assert frame.timestamp_ns == (header + 20) * 50_000


@each(("response_space", "byte_space"), [(0, 0), (36, 0), (0, 4), (4, 2)])
@each("bitwise", [False, True])
def test_spaces_in_responses(response_space: int, byte_space: int, bitwise: bool) -> None:
    """PT-CT 20."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.wire.bitwise = bitwise
        bus.slave(responses={0x10: DATA}, response_space_bits=response_space, byte_space_bits=byte_space)
        master = bus.master()
        master.ask(0x10, 8)
        frame = master.expect(0x10, within=0.1)
        assert frame.timestamp_ns == (34 + response_space + 90 + 8 * byte_space) * 50_000


@pytest.mark.parametrize("length", [0, 2])
def test_a_response_that_comes_too_late_is_none(length: int) -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={0x10: b"\1\2"}, response_space_bits=100)
        master = bus.master()
        master.events()
        master.ask(0x10, length)
        lab.run_until_idle()
        errors = [(event.error, event.timestamp_ns // 50_000) for event in master.events(LinEventKind.ERROR)]
        assert errors == [
            (LinErrorKind.OTHER if length == 0 else LinErrorKind.SLNORE, 34 + (42 if length else 126))
        ]
        assert master.receive() is None


def test_other_lengths_than_expected() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={1: b"\1\2", 2: b"\1\2\3\4"})
        master = bus.master()
        master.events()
        master.ask(1, 4)
        lab.run_until_idle()
        master.ask(2, 2)
        lab.run_until_idle()
        kinds = [event.error for event in master.events(LinEventKind.ERROR)]
        assert kinds == [LinErrorKind.OTHER, LinErrorKind.CHKSUM]  # too few bytes; the third is no checksum
        assert master.receive() is None


@given(st.integers(0, 63), st.binary(max_size=8), st.booleans(), st.booleans())
def test_every_frame_arrives_as_it_was_sent(id: int, data: bytes, classic: bool, published: bool) -> None:
    frame = LinFrame(id, data, enhanced=False if classic else None)
    with Lab() as lab:
        bus = lab.lin_bus()
        slave, listener = bus.slave(), bus.slave("listener")
        master = bus.master()
        if published:
            slave.respond(id, frame)
            master.ask(id)
        else:
            master.send(frame)
        lab.run_until_idle()
        heard = [listener.receive(), (master if published else slave).receive()]
        assert heard == [frame, frame]


def test_a_slave_s_table_may_change_between_header_and_header() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave(responses={7: b"\1"})
        master = bus.master()
        master.ask(7)
        lab.run_until(34 * 50_000 - 1)
        slave.respond(7, b"\2")  # in time for the end of the header
        lab.run_until_idle()
        master.ask(7)
        lab.run_until(lab.now_ns + 40 * 50_000)
        slave.respond(7, b"\3")  # too late for this one
        lab.run_until_idle()
        assert [frame.data for frame in master.receive_many(9)] == [b"\2", b"\2"]


@pytest.mark.parametrize("id", [0x3E, 0x3F])
def test_nobody_answers_reserved_identifiers_by_itself(id: int) -> None:
    """PT-CT 33."""
    with Lab() as lab:
        bus = lab.lin_bus()
        bus.slave(responses={0x10: b"\1"})
        master = bus.master()
        master.ask(id)
        lab.run_until_idle()
        assert master.receive() is None


def test_what_was_on_the_wire() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        bus.remember(2)
        bus.slave("door", responses={7: b"\1"})
        master = bus.master()
        for _ in range(2):
            master.ask(7)
        master.send(LinFrame(8, b"\2"))
        lab.run_until_idle()
        assert bus.recent() == [("door", LinFrame(7, b"\1")), ("master", LinFrame(8, b"\2"))]
        assert bus.frames == 3
