"""The small J1939 ECU, on can-j1939, in the lab's time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

import pytest

from canwire import BadValue, Frame, Lab, LabBus, LabNode, load_database

j1939 = pytest.importorskip("j1939")

from canwire.ecus import J1939Ecu, LabJ1939  # noqa: E402
from tests.docs.blocks import ROOT  # noqa: E402

pytestmark = pytest.mark.conforms("PP-03")
MS = 1_000_000
VIN = b"CANWIRE0123456789*"
CLAIM, REQUEST, MANY, TRANSPORT = 0xEE00, 0xEA00, 0xEB00, 0xEC00  # the last two: TP.DT and TP.CM


class Heard(NamedTuple):
    """A message that an ECU got, and when."""

    at_ms: float
    pgn: int
    source: int
    data: bytes


class Bench:
    """A bus of 250 kbit/s; every frame is heard by `listener`."""

    def __init__(self, lab: Lab) -> None:
        self.lab = lab
        self.bus: LabBus = lab.can_bus("can0", bit_rate=250_000)
        self.listener: LabNode = self.bus.node("listener")
        self.heard: list[Heard] = []

    def ecu(self, address: int, identity: int, *, arbitrary: bool = True, **more: Any) -> J1939Ecu:
        """On the bus at once; a lower identity wins contests among those that can take any address."""
        name = j1939.Name(identity_number=identity, arbitrary_address_capable=arbitrary)
        made = J1939Ecu(address, name=name, **more)
        self.bus.node(f"ecu{identity}", made)
        return made

    def tester(self, address: int = 0xF9) -> J1939Ecu:
        def hear(pgn: int, source: int, data: bytes) -> None:
            self.heard.append(Heard(self.lab.now_ns / MS, pgn, source, data))

        return self.ecu(address, 99, arbitrary=False, on_message=hear)

    def frames(self, pgn: int) -> list[Frame]:
        """Those of this group since the last call, whoever they are for; all else is dropped."""
        mask = 0x3FFFF00 if pgn >= 0xF000 else 0x3FF0000
        return [one for one in self.listener.receive_many(100_000) if one.id & mask == pgn << 8]


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Lab() as lab:
        yield Bench(lab)


@pytest.mark.smoke
def test_an_address_is_claimed(bench: Bench) -> None:
    """128 to 247 wait 250 ms for a veto, others begin at once; nothing is sent before."""
    ecu, tester = bench.ecu(0x80, 1, groups={0xFEEE: b"\5" * 8}, cycles={0xFEEE: 0.1}), bench.tester()
    assert (ecu.state, ecu.address) == ("not started", None)
    with pytest.raises(RuntimeError, match="address claiming"):
        ecu.send(0xFEEE, b"")
    bench.lab.run_for(0.6)
    assert (ecu.state, ecu.address, tester.address) == ("claiming", None, 0xF9)
    assert bench.frames(0xFEEE) == []
    bench.lab.run_for(0.2)
    assert (ecu.state, ecu.address) == ("claimed", 0x80)
    assert repr(ecu) == "<J1939 ECU 0x8000000000000001: claimed, address 0x80>"
    bench.lab.run_for(0.2)
    assert [frame.id for frame in bench.frames(0xFEEE)] == [0x18FEEE80] * 2


def test_a_lost_contest_leads_to_the_next_address(bench: Bench) -> None:
    loser, winner = bench.ecu(0x80, 2), bench.ecu(0x80, 1)
    bench.lab.run_for(0.7)
    bench.lab.run_for(0.8)
    assert (winner.address, loser.address) == (0x80, 0x81)
    claims = [(frame.id & 0xFF, frame.data[0]) for frame in bench.frames(CLAIM)]
    assert claims[-1] == (0x81, 2)
    assert (0x80, 1) in claims


def test_a_latecomer_with_a_lower_name_takes_the_address(bench: Bench) -> None:
    first, tester = bench.ecu(0x80, 2, groups={0xFEEE: b"\5" * 8}), bench.tester()
    bench.lab.run_for(1)
    second = bench.ecu(0x80, 1)
    bench.lab.run_for(1.5)
    assert (first.address, second.address) == (0x81, 0x80)
    tester.application.send_request(0, 0xFEEE, 0x81)
    bench.lab.run_for(0.1)
    assert [(one.pgn, one.source) for one in bench.heard] == [(0xFEEE, 0x81)]


def test_who_cannot_move_cannot_claim(bench: Bench) -> None:
    """It says so from address 254, and is silent from then on."""
    loser = bench.ecu(0x80, 1 << 10, arbitrary=False, groups={0xFEEE: b"\5" * 8}, cycles={0xFEEE: 0.1})
    bench.lab.run_for(1)
    bench.ecu(0x80, 1, arbitrary=False)
    bench.lab.run_for(1)
    assert (loser.state, loser.address) == ("cannot claim", None)
    assert bench.frames(CLAIM)[-1].id == 0x18EEFFFE
    assert repr(loser).endswith("cannot claim, no address>")
    bench.lab.run_for(1)
    assert bench.frames(0xFEEE) == []


def test_who_has_the_lower_name_stays(bench: Bench) -> None:
    ecu = bench.ecu(0x80, 1)
    bench.lab.run_for(1)
    rival = bench.ecu(0x80, 2)
    bench.lab.run_for(1.5)
    assert (ecu.address, rival.address) == (0x80, 0x81)


def test_requests(bench: Bench) -> None:
    """Who asks gets the group, a name, or a negative acknowledgment; who asks everybody gets none of the latter."""
    counted = iter(range(10))
    bench.ecu(0x80, 1, groups={0xFEEE: lambda: bytes([next(counted)]) * 8, 0xEF00: b"to you"})
    ask = bench.tester().application.send_request
    bench.lab.run_for(1)
    for group, destination in (
        (0xFEEE, 0x80),
        (0xFEEE, 0xFF),
        (0xEF00, 0x80),
        (0xFECA, 0x80),
        (0xFECA, 0xFF),
    ):
        ask(0, group, destination)
        bench.lab.run_for(0.1)
    assert [one[1:] for one in bench.heard] == [
        (0xFEEE, 0x80, bytes(8)),
        (0xFEEE, 0x80, b"\1" * 8),
        (0xEF00, 0x80, b"to you"),
        (0xE800, 0x80, bytes.fromhex("01ffffff f9 cafe00")),
    ]
    bench.listener.receive_many(1000)
    ask(0, CLAIM, 0xFF)
    bench.lab.run_for(0.1)
    assert sorted(frame.id for frame in bench.frames(CLAIM)) == [
        0x18EEFF80
    ]  # its own is not heard by who asks


@pytest.mark.parametrize("size", [9, 14, 15, 100, 1785])
def test_long_messages_to_everybody(bench: Bench, size: int) -> None:
    """BAM: 50 ms from packet to packet, and nobody answers."""
    ecu = bench.ecu(0x80, 1)
    bench.tester()
    bench.lab.run_for(1)
    bench.listener.receive_many(100)
    data = bytes(number * 7 & 0xFF for number in range(size))
    ecu.send(0xFEEC, data)
    bench.lab.run_until_idle()
    assert [one[1:] for one in bench.heard] == [(0xFEEC, 0x80, data)]
    frames = bench.listener.receive_many(1000)
    packets = -(-size // 7)
    assert len(frames) == 1 + packets
    apart = [after.timestamp_ns - before.timestamp_ns for before, after in pairwise(frames)]
    assert all(49.9 * MS <= each < 50.1 * MS for each in apart)  # stuffed bits make frames unlike


@pytest.mark.parametrize("size", [9, 100, 1785])
def test_long_messages_to_one(bench: Bench, size: int) -> None:
    """RTS, CTS for each packet, an end of message: both ways, at once."""
    heard: list[tuple[int, int, bytes]] = []
    ecu, tester = bench.ecu(0x80, 1, on_message=lambda *words: heard.append(words)), bench.tester()
    bench.ecu(0x90, 2, on_message=lambda *words: heard.append(words))  # is meant by none of it
    bench.lab.run_for(1)
    bench.listener.receive_many(100)
    data = bytes(number * 7 & 0xFF for number in range(size))
    ecu.send(0xEF00, data, destination=0xF9)
    tester.send(0xEF00, data[::-1], destination=0x80)
    bench.lab.run_until_idle()
    assert [one[1:] for one in bench.heard] == [(0xEF00, 0x80, data)]
    assert heard == [(0xEF00, 0xF9, data[::-1])]
    control = [frame.data[0] for frame in bench.frames(TRANSPORT)]
    packets = -(-size // 7)
    assert (control.count(16), control.count(17), control.count(19)) == (2, 2 * packets, 2)


@pytest.mark.parametrize(("packets", "clears"), [(1, 15), (4, 4), (255, 1)])
def test_how_many_packets_a_cts_allows(bench: Bench, packets: int, clears: int) -> None:
    heard: list[tuple[int, int, bytes]] = []
    receiver, sender = J1939Ecu(0x10, on_message=lambda *words: heard.append(words)), J1939Ecu(0x20)
    for name, each in (("receiver", receiver), ("sender", sender)):
        each.start(LabJ1939(bench.bus.node(name), max_cmdt_packets=packets))
    bench.lab.run_for(1)
    sender.send(0xEF00, bytes(range(100)), destination=0x10)
    bench.lab.run_until_idle()
    assert heard == [(0xEF00, 0x20, bytes(range(100)))]
    assert [frame.data[0] for frame in bench.frames(TRANSPORT)].count(17) == clears


def test_long_messages_wait_their_turn(bench: Bench) -> None:
    """can-j1939 takes one at a time to each destination; a short one goes between the packets of the last."""
    ecu = bench.ecu(0x80, 1)
    bench.tester()
    bench.lab.run_for(1)
    for number in range(4):
        ecu.send(0xFE00 + number, bytes([number]) * 20)
    ecu.send(0xFEEE, b"short", priority=3)
    bench.lab.run_for(2)
    assert [one.pgn for one in bench.heard] == [0xFE00, 0xFE01, 0xFE02, 0xFEEE, 0xFE03]
    assert [len(one.data) for one in bench.heard] == [20, 20, 20, 5, 20]


def test_a_receiver_that_falls_silent_ends_the_transfer(bench: Bench) -> None:
    """T3 is over in the lab after 1.25 s; the connection is aborted for its timeout (3)."""
    ecu = bench.ecu(0x80, 1)
    bench.lab.run_for(1)
    bench.listener.receive_many(100)
    ecu.send(0xEF00, bytes(100), destination=0x33)
    bench.lab.run_until_idle()
    request, abort = bench.frames(TRANSPORT)
    assert (request.data[0], abort.data[:2]) == (16, b"\xff\3")
    assert 1250 * MS <= abort.timestamp_ns - request.timestamp_ns < 1252 * MS


def test_a_sender_that_falls_silent_ends_the_transfer(bench: Bench) -> None:
    """T1 after a packet, and nothing is heard of the half message."""
    bench.tester(0x40)
    raw = bench.bus.node("raw")
    bench.lab.run_for(1)
    raw.send(Frame(0x18EC4033, bytes.fromhex("10 1400 03 ff 00ef00"), extended=True))
    raw.send(Frame(0x18EB4033, bytes.fromhex("01 11223344556677"), extended=True))
    bench.lab.run_until_idle()
    clear, _, abort = [one for one in bench.frames(TRANSPORT) if one.id & 0xFF == 0x40]
    assert (clear.data[0], abort.data[:2]) == (17, b"\xff\3")
    assert bench.heard == []


def test_faults_go_out_each_second(bench: Bench) -> None:
    """DM1 by can-j1939's own, read by its own; one fault in a frame, two by BAM."""
    ecu = bench.ecu(0x80, 1)
    told: list[Any] = []
    tester = bench.tester()
    j1939.Dm1(tester.application).subscribe(
        lambda source, lamps, faults, stamp: told.append((source, lamps["mil"], faults))
    )
    ecu.set_faults([{"spn": 110, "fmi": 3}], {"mil": j1939.DtcLamp.ON})
    bench.lab.run_for(2.5)
    coolant, oil = {"spn": 110, "fmi": 3, "oc": 0}, {"spn": 100, "fmi": 1, "oc": 7}
    assert told == [(0x80, j1939.DtcLamp.ON, [coolant])] * 2
    ecu.set_faults([coolant, oil])
    told.clear()
    bench.lab.run_for(1)
    assert told == [(0x80, j1939.DtcLamp.OFF, [coolant, oil])]


def test_a_database_decodes_what_it_sends(bench: Bench) -> None:
    """The file says 0CF00400; whatever address the ECU has got, its messages are EEC1."""
    pytest.importorskip("cantools")
    engine = load_database(ROOT / "examples" / "engine.dbc")
    groups = {0xF004: lambda: engine.encode("EEC1", {"EngSpeed": 1234}).data}
    bench.ecu(0x80, 1, arbitrary=False)
    ecu = bench.ecu(0x80, 2, groups=groups, cycles={0xF004: 0.02})
    tester = engine.on(bench.bus.node("database", filters=engine.acceptance("EEC1")))
    bench.lab.run_for(2)
    assert ecu.address == 0x81
    told = tester.expect_message("EEC1", EngSpeed=1234, within=0.1)
    assert (told.source, told.frame.id) == (0x81, 0x18F00481)


def test_what_cannot_be() -> None:
    with pytest.raises(BadValue, match="address 254: 0 to 253"):
        J1939Ecu(254)
    with pytest.raises(BadValue, match="0xfeee is not among the groups"):
        J1939Ecu(1, cycles={0xFEEE: 1})
    with pytest.raises(BadValue, match="0xfeec: 1786 bytes; 1785 fit"):
        J1939Ecu(1, groups={0xFEEC: bytes(1786)})
    with pytest.raises(BadValue, match="0x20000: up to 0x1ffff"):
        J1939Ecu(1, groups={0x20000: b""})
    with pytest.raises(BadValue, match="1786 bytes; 1785 fit"):
        J1939Ecu(1).send(0xFEEE, bytes(1786))


def test_units_end(bench: Bench) -> None:
    unit = LabJ1939(bench.bus.node("unit"))
    ecu = J1939Ecu(0x80, groups={0xFEEE: b""}, cycles={0xFEEE: 0.1})
    ecu.start(unit)
    ticks: list[int] = []
    unit.add_timer(0.1, ticks.append, 1)
    bench.lab.run_for(1.05)
    assert (len(bench.frames(0xFEEE)), ticks) == (3, [1])
    unit.disconnect()
    bench.lab.run_for(5)
    assert bench.frames(0xFEEE) == []
    assert repr(unit) == "<J1939 on can0/unit: 1 applications; 0 errors>"


def test_others_in_this_process_keep_the_wall_clock(bench: Bench) -> None:
    """Only the lab's copy of the transport layer goes by its time; nobody's module is changed."""
    LabJ1939(bench.bus.node("unit"))
    from j1939 import electronic_control_unit, j1939_21

    assert j1939_21.time is time
    assert electronic_control_unit.time is time
    assert electronic_control_unit.J1939_21 is j1939_21.J1939_21


def test_the_same_again(bench: Bench) -> None:
    """Frames and their times, to the nanosecond."""

    def once() -> list[Frame]:
        with Lab() as lab:
            again = Bench(lab)
            again.ecu(0x80, 2, groups={0xFEEC: VIN}, cycles={0xFEEC: 0.3})
            again.ecu(0x80, 1)
            lab.run_for(3)
            return again.listener.receive_many(10_000)

    first = once()
    assert len(first) > 20
    assert once() == first
    assert [frame.timestamp_ns for frame in once()] == [frame.timestamp_ns for frame in first]
