"""A lab's buses for python-can: in the lab's time, beside its nodes and scripts."""

from __future__ import annotations

import threading

import pytest

import canwire
from canwire import Frame, Lab, LabBus, NodeScript

can = pytest.importorskip("can")


class Echo(NodeScript):
    def on_message(self, frame: Frame) -> None:
        self.send(Frame(frame.id + 8, frame.data))


def message(identifier: int, data: bytes = b"") -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, is_extended_id=False)


def test_a_script_answers_a_python_can_program(canwire_bus: LabBus) -> None:
    canwire_bus.node("echo", Echo())
    with can.Bus(interface="canwire", channel=canwire_bus) as bus:
        bus.send(message(0x100, b"hi"))
        heard = bus.recv(1)
    assert heard is not None
    assert (heard.arbitration_id, bytes(heard.data), heard.channel) == (0x108, b"hi", "can0")


def test_frames_go_both_ways_whoever_lets_time_pass(canwire_bus: LabBus) -> None:
    node = canwire_bus.node("node")
    with can.Bus(interface="canwire", channel=canwire_bus) as bus:
        bus.send(message(0x100))
        assert node.expect(0x100, within=0.01)
        node.send(Frame(0x200))
        assert bus.recv(0.01).arbitration_id == 0x200
        bus.send(message(0x101))
        canwire_bus.time.run_until_idle()
        assert [frame.id for frame in node.receive_many(9)] == [0x101]


def test_by_name_with_the_lab_as_hub_at_the_buss_rates(canwire_lab: Lab) -> None:
    canwire_lab.can_bus("can0", bit_rate=250_000)
    later = canwire_lab.can_bus("can1", bit_rate=1_000_000, data_bit_rate=4_000_000)
    with (
        can.Bus("can0", interface="canwire", hub=canwire_lab) as slow,
        can.Bus("can1", interface="canwire", hub=canwire_lab, fd=True) as quick,
    ):
        modes = [bus.line_status().mode for bus in (slow, quick)]
        assert [mode.timing.bit_rate for mode in modes if mode is not None] == [250_000, 1_000_000]
        assert modes[1].data_timing.bit_rate == 4_000_000
        assert len(later.wire.nodes) == 1
    assert (len(later.wire.nodes), canwire_lab.hub().boards()) == (0, ())


def test_a_bus_that_the_lab_does_not_have_is_named(canwire_bus: LabBus, canwire_lab: Lab) -> None:
    with pytest.raises(can.CanInitializationError, match="no CAN bus 'can7'; there are can0"):
        can.Bus("can7", interface="canwire", hub=canwire_lab)


def test_a_thread_and_lab_nodes_keep_the_labs_time(canwire_lab: Lab, canwire_bus: LabBus) -> None:
    node = canwire_bus.node("node")
    with canwire.in_time(canwire_lab), can.Bus(interface="canwire", channel=canwire_bus) as bus:

        def answer() -> None:
            for heard in bus:
                if heard.arbitration_id == 0x7FF:
                    return
                bus.send(message(heard.arbitration_id + 8))

        ecu = threading.Thread(target=answer)
        ecu.start()
        node.send(Frame(0x100))
        assert node.expect(0x108, within=0.01).timestamp_ns < 1_000_000
        canwire_lab.run_for(1)
        node.send(Frame(0x7FF))
        ecu.join()
    assert 1_000_000_000 < canwire_lab.now_ns < 1_001_000_000


def test_after_the_lab_is_closed_the_bus_says_so() -> None:
    with Lab() as lab:
        bus = can.Bus(interface="canwire", channel=lab.can_bus("can0"))
    with pytest.raises(can.CanOperationError):
        bus.send(message(1))
    bus.shutdown()
