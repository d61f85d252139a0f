"""Two who send at once: the wire is the AND of both, senders read it back, listeners make of it what they can."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Lab, LinErrorKind, LinEventKind, LinFrame, LinSlot, lin_checksum, protected_id
from canwire.bus.lin.bits import byte_levels
from canwire.bus.lin.node import LinResponse
from tests.effort import examples

pytestmark = pytest.mark.core

BIT_NS = 50_000


def anded(one: bytes, other: bytes) -> bytes:
    return bytes(a & b for a, b in zip(one, other, strict=True))


@examples(60)
@given(st.binary(min_size=1, max_size=8), st.data())
def test_two_who_answer_make_the_and_of_their_bytes(first: bytes, data: st.DataObject) -> None:
    """Each sender stops with the first byte that it cannot read back; the other's bytes go on."""
    second = data.draw(st.binary(min_size=len(first), max_size=len(first)))
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        nodes = [bus.slave("one", responses={9: first}), bus.slave("other", responses={9: second})]
        listener, master = bus.slave("listener"), bus.master()
        for node in (*nodes, listener, master):
            node.events()
        master.ask(9, len(first))
        lab.run_until_idle()

        sent = [LinResponse.to_send(9, payload, True).octets for payload in (first, second)]
        wire, left = bytearray(), {0, 1}
        for pair in zip(*sent, strict=True):
            octet = 0xFF
            for k in left:
                octet &= pair[k]
            wire.append(octet)
            left -= {k for k in left if pair[k] != octet}
            if not left:
                break
        for k, node in enumerate(nodes):
            kinds = [event.error for event in node.events(LinEventKind.ERROR)]
            assert kinds == ([] if k in left else [LinErrorKind.BIT])
        whole = len(wire) == len(sent[0])
        right = whole and wire[-1] in (
            lin_checksum(bytes(wire[:-1])),
            lin_checksum(bytes(wire[:-1]), protected_id(9)),
        )
        errors = [event.error for event in listener.events(LinEventKind.ERROR)]
        if right:
            assert (errors, listener.receive()) == ([], LinResponse_frame(wire))
        else:
            assert errors == [LinErrorKind.CHKSUM if whole else LinErrorKind.OTHER]
        assert [event.error for event in master.events(LinEventKind.ERROR)] == errors


def LinResponse_frame(wire: bytearray) -> LinFrame:  # noqa: N802
    heard = LinResponse.heard(9, bytes(wire))
    return LinFrame(9, heard.octets[:-1], enhanced=bool(heard.enhanced))


def test_a_sender_stops_after_the_byte_it_could_not_read_back() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        loser = bus.slave("loser", responses={9: b"\xff\xff\xff"})
        winner = bus.slave("winner", responses={9: b"\x00\xff\xff"})
        loser.events()
        changes: list[tuple[int, int]] = []
        bus.wire.bits.capture = lambda at_ps, level: changes.append((at_ps // 1000 // BIT_NS, level))
        bus.master().ask(9)
        lab.run_until_idle()
        (event,) = loser.events(LinEventKind.ERROR)
        assert (event.error, event.id, event.transmitting) == (LinErrorKind.BIT, 9, True)
        assert event.timestamp_ns == (34 + 1) * BIT_NS + BIT_NS // 2  # its first data bit, in the middle
        assert loser.counters.frames_sent == 0
        assert winner.counters.frames_sent == 1
        assert loser.response_error
        assert not winner.response_error
        rest = byte_levels(0xFF) * 2 + byte_levels(lin_checksum(b"\0\xff\xff", protected_id(9)))
        levels = [[level for at, level in changes if at <= 44 + k][-1] for k in range(30)]
        assert bytes(levels) == rest  # the winner's alone


def test_different_lengths_and_starts_collide_bit_by_bit() -> None:
    """Who answers later drives dominant bits into the other's."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        early = bus.slave("early", responses={9: b"\xff" * 8})
        late = bus.slave("late", responses={9: b"\x00"}, response_space_bits=25)
        listener = bus.slave("listener")
        for node in (early, late, listener):
            node.events()
        bus.master().ask(9)
        lab.run_until_idle()
        assert [event.error for event in early.events(LinEventKind.ERROR)] == [LinErrorKind.BIT]
        assert late.events(LinEventKind.ERROR) == []  # the other one had let go when it sent its stop bit
        assert listener.receive() is None
        assert len(listener.events(LinEventKind.ERROR)) == 1


def test_a_second_master_is_refused_unless_it_says_so() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        bus.master("first")
        with pytest.raises(ValueError, match="'first' is its master already"):
            bus.master("second")
        bus.master("second", rival=True)


def test_two_masters_that_start_together_collide_in_the_identifier() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave(responses={0x10: b"\1", 0x11: b"\2"})
        one, other = bus.master("one"), bus.master("other", rival=True)
        for node in (one, other, slave):
            node.events()
        one.ask(0x10)  # 0x50
        other.ask(0x3F)  # 0xBF
        lab.run_until_idle()
        both = protected_id(0x10) & protected_id(0x3F)
        assert both == 0x10  # neither's, and its parity is wrong
        assert [event.error for event in one.events(LinEventKind.ERROR)] == [LinErrorKind.BIT]
        assert [event.error for event in other.events(LinEventKind.ERROR)] == [LinErrorKind.BIT]
        assert [event.error for event in slave.events(LinEventKind.ERROR)] == [LinErrorKind.PARITY]
        one.ask(0x10)
        lab.run_until_idle()
        assert one.expect(0x10, within=0.01).data == b"\1"


def test_the_master_whose_identifier_prevails_goes_on() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={0x00: b"\1"})
        one, other = bus.master("one"), bus.master("other", rival=True)
        other.events()
        one.ask(0x00)  # 0x80
        other.ask(0x01)  # 0xC1: every dominant bit of 0x80 and more ones
        lab.run_until_idle()
        assert one.expect(0x00, within=0.01).data == b"\1"
        assert [event.error for event in other.events(LinEventKind.ERROR)] == [LinErrorKind.BIT]


def test_masters_with_equal_headers_both_go_on() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={7: b"\1"})
        masters = [bus.master("one"), bus.master("other", rival=True)]
        for master in masters:
            master.ask(7)
        lab.run_until_idle()
        assert [master.expect(7, within=0.01).timestamp_ns for master in masters] == [54 * BIT_NS] * 2


def test_a_master_waits_while_the_other_one_s_frame_lasts() -> None:
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        bus.slave(responses={1: b"\1", 2: b"\2"})
        one, other = bus.master("one"), bus.master("other", rival=True)
        one.ask(1)
        lab.run_until(1)
        other.ask(2)
        lab.run_until_idle()
        assert [frame.timestamp_ns for frame in other.receive_many(9)] == [54 * BIT_NS, 108 * BIT_NS]


def test_two_schedules_on_one_wire() -> None:
    """Every slot of the one meets the other's: nothing gets through, and neither ever stops."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave(responses={0x10: b"\1", 0x3F: b"\2"})
        one = bus.master("one", schedule=[0x10])
        other = bus.master("other", schedule=[0x3F], rival=True)
        lab.run_for(0.1)
        assert slave.counters.frames_sent == 0
        assert one.counters.errors[LinErrorKind.BIT] == other.counters.errors[LinErrorKind.BIT] == 10
        other.schedule.stop()
        lab.run_for(0.1)
        assert slave.counters.frames_sent == 9


@pytest.mark.parametrize("length", [2, 8])
def test_a_break_in_the_middle_of_a_frame_begins_a_new_one(length: int) -> None:
    """A master whose clock is off by 10 % cannot follow the other one, and takes the bus to be free."""
    with Lab() as lab:
        bus = lab.lin_bus(bit_rate=20_000)
        slave = bus.slave(responses={1: b"\xff" * length, 2: b"\2"})
        listener = bus.slave("listener")
        one = bus.master("one")
        other = bus.master("other", rival=True, oscillator_ppm=-100_000)
        for node in (one, slave, listener, other):
            node.events()
        one.ask(1, length)
        lab.run_until(47 * BIT_NS)  # in the second byte
        other.ask(2)
        lab.run_until_idle()
        assert [event.error for event in other.events(LinEventKind.ERROR)] == [LinErrorKind.SYNC]
        assert [event.error for event in slave.events(LinEventKind.ERROR)] == [LinErrorKind.BIT]
        assert [event.error for event in listener.events(LinEventKind.ERROR)] == [LinErrorKind.OTHER]
        assert listener.expect(2, within=0.01).data == b"\2"
        assert other.expect(2, within=0.01).data == b"\2"


def test_an_event_triggered_collision_sets_no_response_error() -> None:
    with Lab() as lab:
        bus = lab.lin_bus()
        slaves = [
            bus.slave("a", responses={0x11: bytes([0, 1])}, events={0x20: 0x11}),
            bus.slave("b", responses={0x12: bytes([0, 2])}, events={0x20: 0x12}),
        ]
        bus.master(schedule=[LinSlot.event(0x20, [0x11, 0x12])])
        lab.run_until_idle()
        assert [slave.response_error for slave in slaves] == [False, False]
        assert sum(slave.counters.errors[LinErrorKind.BIT] for slave in slaves) >= 1
