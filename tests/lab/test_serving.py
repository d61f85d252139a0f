"""A lab's buses shared with programs: its nodes and theirs hear each other in real time, and suffer the same faults."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import BadValue, Frame, Hub, HubLost, Lab, LabBus, NodeScript, NoSuchBoard, find_lines
from canwire.bus.can.bus import CanBus
from tests.hub.faults.bench import Program

LONG_S = 30.0


class Echo(NodeScript):
    """Answers each frame with the next identifier."""

    def on_message(self, frame: Frame) -> None:
        self.send(Frame(frame.id + 1, frame.data))


@pytest.fixture
def lab() -> Iterator[Lab]:
    with Lab(time="real") as made:
        yield made


@pytest.fixture
def bus(lab: Lab) -> LabBus:
    return lab.can_bus("body", bit_rate=500_000)


@pytest.fixture
def address(lab: Lab, bus: LabBus, tmp_path: Path) -> str:
    return lab.serve(str(tmp_path / "lab.sock"))


@pytest.fixture
def hub(address: str) -> Iterator[Hub]:
    with canwire.connect(address, name="program") as made:
        yield made


@pytest.mark.conforms("N-14")
def test_a_program_and_a_node_hear_each_other(bus: LabBus, hub: Hub) -> None:
    bus.node("echo", Echo())
    (place, _) = find_lines(hub, "body")
    program = Program(hub, place.address)
    program.send(Frame(0x10, b"\x01"))
    assert [(frame.id, frame.data) for frame in program.frames()] == [(0x11, b"\x01")]


def test_a_thousand_frames_each_way_and_none_lost(bus: LabBus, hub: Hub) -> None:
    bus.node("echo", Echo())
    program = Program(hub, find_lines(hub, "body")[0].address)
    program.send(Frame(0x10), 1000)
    heard: list[int] = []
    while len(heard) < 1000:
        heard += [frame.id for frame in program.frames()]
    assert (set(heard), program.lost(), bus.nodes["echo"].lost) == ({0x11}, 0, 0)


@pytest.mark.conforms("N-14")
@pytest.mark.usefixtures("python_can_without_mf4")
def test_a_program_in_a_process_of_its_own(bus: LabBus, address: str) -> None:
    bus.node("echo", Echo())
    pytest.importorskip("can")
    code = (
        "import can, sys\n"
        "with can.Bus('body', interface='canwire', hub=sys.argv[1], bitrate=500_000) as bus:\n"
        "    bus.send(can.Message(arbitration_id=0x20, data=[7], is_extended_id=False))\n"
        "    print(f'{bus.recv(30).arbitration_id:X}')\n"
    )
    ended = subprocess.run([sys.executable, "-c", code, address], capture_output=True, text=True, timeout=60)
    assert (ended.stdout, ended.returncode) == ("21\n", 0), ended.stderr


@pytest.mark.conforms("N-14")
def test_faults_of_the_lab_and_of_the_hub_meet_everybody(bus: LabBus, hub: Hub) -> None:
    sender = bus.node("sender")
    bus.node("third")
    program = Program(hub, find_lines(hub, "body")[0].address)
    theirs = hub.bus("body").faults.flip(bit=20, frame_id=0x100)
    mine = bus.faults.flip(bit=20, frame_id=0x101)
    sender.send_many([Frame(0x100), Frame(0x101)])
    heard: list[int] = []
    while len(heard) < 2:
        heard += [frame.id for frame in program.frames()]
    assert (heard, theirs.struck, mine.struck) == ([0x100, 0x101], 1, 1)
    waiting = [
        hub.bus("body").faults.noise(1e-9),
        hub.bus("body").faults.flip(bit=3, frame_id=0x7FF, times=None),
    ]
    bus.faults.clear()  # the lab's script is everybody's
    for fault in waiting:
        assert fault.wait(LONG_S)
        assert fault.info().over == "cleared on its bench"
    assert theirs.info().over == "used up"


def test_boards_on_lin_buses_and_further_ones(lab: Lab, bus: LabBus, tmp_path: Path) -> None:
    lab.can_bus("second")
    lab.lin_bus("lin")
    address = lab.serve(str(tmp_path / "more.sock"), boards=["usb-to-can-fd", "inducan104"])
    with canwire.connect(address) as hub:
        lines = [(board.kind, [line.bus for line in board.lines]) for board in hub.boards()]
        assert lines == [("usb-to-can-fd", ["body", "body", "lin"]), ("inducan104", ["body"])]
        added = hub.plug("usb-to-can", buses=("second", "body"))
        assert [line.bus for line in added.lines] == ["second", "body"]


def test_only_a_lab_in_real_time_and_only_once(lab: Lab, address: str) -> None:
    with pytest.raises(BadValue, match=r"served on .* already"):
        lab.serve()
    with Lab() as virtual, pytest.raises(BadValue, match='Lab\\(time="real"\\) can be served'):
        virtual.serve()


def test_what_cannot_be_served_leaves_nothing(lab: Lab, bus: LabBus, tmp_path: Path) -> None:
    with pytest.raises(NoSuchBoard, match="no board kind 'toaster'"):
        lab.serve(str(tmp_path / "x.sock"), boards=["usb-to-can", "toaster"])
    assert not os.path.exists(tmp_path / "x.sock")
    assert bus.wire.nodes == []
    assert lab.serve(str(tmp_path / "x.sock")) == str(tmp_path / "x.sock")


class Broken(NodeScript):
    """Fails at its first frame."""

    def on_message(self, frame: Frame) -> None:
        raise ArithmeticError("a script's own mistake")


def test_a_script_that_fails_ends_the_hub_and_the_lab_says_why(tmp_path: Path) -> None:
    lab = Lab(time="real")
    lab.can_bus("body").node("broken", Broken())
    with canwire.connect(lab.serve(str(tmp_path / "lab.sock"))) as hub:
        fault = hub.bus("body").faults.noise(1e-9)
        program = Program(hub, "HW000001:0")
        program.send()
        with pytest.raises(HubLost):
            fault.wait(LONG_S)
    with pytest.raises(ArithmeticError, match="a script's own mistake"):
        lab.close()
    assert not os.path.exists(tmp_path / "lab.sock")


def test_the_end_of_the_lab_is_the_end_of_its_hub(tmp_path: Path) -> None:
    with Lab(time="real") as lab:
        wire = lab.can_bus("body").wire
        hub = canwire.connect(lab.serve(str(tmp_path / "lab.sock")))
        program = Program(hub, "HW000001:0")
    assert isinstance(wire, CanBus)
    assert wire.nodes == []
    assert not os.path.exists(tmp_path / "lab.sock")
    with pytest.raises((HubLost, canwire.Unplugged)):
        program.channel.status()
    with pytest.raises(HubLost):
        hub.boards()
    hub.close()
