"""Slaves on the bench that are configured over the bus, as bought ones are."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import Lab, LabLinBus, LinFrame, LinSlot, NotReceived, WrongState, ldf
from canwire.values.lin.configuration import LinNodeAttributes, LinProduct

pytestmark = pytest.mark.conforms("N-47")

DOOR = Path(__file__).parents[2] / "examples" / "door.ldf"
ATTRIBUTES = LinNodeAttributes(LinProduct(0x1234, 0x5678, 1), nad=0x11, frames={0: 0x10, 1: 0x20})


@pytest.fixture
def lin_bus(lab: Lab) -> LabLinBus:
    return lab.lin_bus("lin0")


def test_a_frame_moves_with_all_that_is_known_of_it(lab: Lab, lin_bus: LabLinBus) -> None:
    master = lin_bus.master(responses={0x10: b"\x01", 0x05: b"\x02"})
    slave = lin_bus.slave(
        responses={0x20: b"\x00\x07"},
        subscribes={0x10: 1},
        response_error=(0x20, 0),
        checksums={0x10: False},
        attributes=ATTRIBUTES,
    )
    assert master.request(0x11, bytes.fromhex("B700 8547FFFF")) == b"\xf7"  # 0x10 is 0x05, 0x20 is 0x07
    master.receive_many(9)
    master.ask(0x20)
    master.expect_nothing(within=0.1)
    master.ask(0x05)  # enhanced, where the slave takes classic alone
    lab.run_for(0.1)
    assert slave.response_error
    master.ask(0x07)
    assert master.expect(0x07, within=0.1).data == b"\x01\x07"
    assert not slave.response_error


def test_two_frames_change_places(lab: Lab, lin_bus: LabLinBus) -> None:
    master = lin_bus.master()
    attributes = LinNodeAttributes(LinProduct(1, 2), frames={0: 0x10, 1: 0x20})
    lin_bus.slave(responses={0x10: b"A", 0x20: b"B"}, attributes=attributes)
    master.request(1, bytes.fromhex("B700 2050FFFF"))
    for id, data in ((0x10, b"B"), (0x20, b"A")):
        master.ask(id)
        assert master.expect(id, within=0.1).data == data


def test_a_frame_without_an_identifier_comes_back(lab: Lab, lin_bus: LabLinBus) -> None:
    master = lin_bus.master()
    slave = lin_bus.slave(responses={0x20: b"\x09"}, attributes=ATTRIBUTES)
    master.request(0x11, bytes.fromhex("B701 00FFFFFF"))
    master.receive_many(9)
    master.ask(0x20)
    master.expect_nothing(within=0.1)
    slave.power_up()
    master.ask(0x20)
    assert master.expect(0x20, within=0.1).data == b"\x09"


def test_an_event_triggered_frame_follows(lab: Lab, lin_bus: LabLinBus) -> None:
    master = lin_bus.master(schedule=[LinSlot.event(0x28, [0x07])])
    lin_bus.slave(responses={0x20: b"\x00\x01"}, events={0x28: 0x20}, attributes=ATTRIBUTES)
    master.request(0x11, bytes.fromhex("B701 47FFFFFF"))
    assert master.expect(0x28, within=0.1).data == b"\x47\x01"  # the new identifier, protected, in front


def test_long_messages_and_p2(lab: Lab, lin_bus: LabLinBus) -> None:
    asked: list[bytes] = []

    def service(payload: bytes) -> bytes:
        asked.append(payload)
        return b"\x62" + bytes(range(200))

    master = lin_bus.master(schedule=[(0x10, 0.02)])
    attributes = LinNodeAttributes(LinProduct(1, 2), nad=0x05, service=service)
    lin_bus.slave(responses={0x10: b"\x01"}, attributes=attributes)
    began_ns = lab.now_ns
    assert master.request(0x05, b"\x22" + bytes(30), within=5.0) == b"\x62" + bytes(range(200))
    assert asked == [b"\x22" + bytes(30)]
    assert lab.now_ns - began_ns > 50_000_000
    assert master.request(0x7E, b"\x3e\x80") == b""
    lab.run_for(0.1)
    assert asked[1:] == [b"\x3e\x80"]


def test_a_response_that_nobody_fetches_is_given_up(lab: Lab, lin_bus: LabLinBus) -> None:
    master = lin_bus.master()
    lin_bus.slave(attributes=ATTRIBUTES)
    master.send(LinFrame(0x3C, bytes.fromhex("1106B200FF7FFFFF")))
    lab.run_for(0.9)
    master.ask(0x3D)
    assert master.expect(0x3D, within=0.1).data == bytes.fromhex("1106F23412785601")
    master.ask(0x3D)
    master.expect_nothing(within=0.1)  # PT-CT 84: fetched already
    master.send(LinFrame(0x3C, bytes.fromhex("1106B200FF7FFFFF")))
    lab.run_for(1.1)
    master.ask(0x3D)
    master.expect_nothing(within=0.1)  # N_As


def test_slaves_of_one_nad_are_told_apart(lab: Lab, lin_bus: LabLinBus) -> None:
    """Two of the same kind leave the factory with the same NAD: AssignNAD cannot tell them apart, a serial can."""
    master = lin_bus.master()
    for serial in (4, 5):
        attributes = LinNodeAttributes(LinProduct(0x1234, 0x5678), nad=0x01, serial=serial)
        lin_bus.slave(f"slave {serial}", attributes=attributes)
    assert master.request(0x01, bytes([0xB3, 1, 1, 0xFF, 5, 0x22])) == b"\xf3"
    for nad, serial in ((0x01, 4), (0x22, 5)):
        assert master.request(nad, bytes.fromhex("B201FF7FFFFF")) == b"\xf2" + serial.to_bytes(4, "little")


def test_nobody_answers(lab: Lab, lin_bus: LabLinBus) -> None:
    master, slave = lin_bus.master(), lin_bus.slave(attributes=ATTRIBUTES)
    with pytest.raises(NotReceived, match="no response of NAD 0x12"):
        master.request(0x12, bytes.fromhex("B200FF7FFFFF"), within=0.2)
    with pytest.raises(WrongState):
        slave.request(0x12, b"\xb6")


def test_a_description_is_configured_by_its_own_schedule(lab: Lab) -> None:
    """door.ldf's table Setup: the left window goes from its initial to its configured NAD, then is identified."""
    pytest.importorskip("ldfparser")
    network = ldf.load(DOOR)
    bus = lab.lin_bus("lin0", bit_rate=network.bit_rate)
    master = bus.master(network.master, schedule=network.schedules, **network.master_options())
    slaves = {name: bus.slave(name, **network.slave_options(name)) for name in network.slaves}
    left = slaves["left"].configuration
    assert left is not None
    assert left.nad == 0x11
    assert slaves["mirror"].configuration is None  # LIN 1.3 knows no node configuration
    lab.run_for(1.0)
    master.schedule.start("Setup", rounds=1)
    assert master.expect(0x3D, within=2.0).data == bytes.fromhex("1101F0FFFFFFFFFF")
    assert left.nad == 0x01
    lab.run_for(1.0)
    assert master.request(0x01, bytes.fromhex("B200FF7FFFFF")) == bytes.fromhex("F23412785601")
