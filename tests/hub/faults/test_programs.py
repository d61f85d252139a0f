"""Programs of every interface meet error frames, error passive and bus-off on a shared bus, and report it their way."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire import Frame, Hub, acan, candrv, vci
from canwire.acan import Condition
from canwire.acan.mirrored_block import MirroredBlock
from canwire.acan.structures import ACANID, ACANTB
from canwire.candrv import CanbusEvent, ControlCode, Handle
from canwire.candrv.ioctl import control
from canwire.vci import v3
from tests.hub.faults.bench import MCP2515, OTHER, SJA1000, Program
from tests.hub.faults.conftest import Programs
from tests.vci.programs import Program as VciProgram
from tests.vci.v3.programs import BOTH as V3_BOTH
from tests.vci.v3.programs import NetProgram

can = pytest.importorskip("can")
BOTH = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
ERRORS = BOTH | vci.CAN_OPMODE_ERRFRAME
CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE = 0x4, 0x20  # <linux/can/error.h>
PASSIVE_ATTEMPTS, OFF_ATTEMPTS = 16, 32  # TEC 8 more each


# VCI V4


@pytest.fixture
def vci_program(program: Programs) -> Iterator[VciProgram]:
    with contextlib.closing(VciProgram(program("a VCI program"))) as made:
        yield made


@pytest.mark.smoke
@pytest.mark.conforms("N-09")
def test_vci_error_message_passive_and_bus_off(hub: Hub, vci_program: VciProgram) -> None:
    sender, receiver = vci_program.port(0), vci_program.port(1)
    control, _ = (vci_program.start(line, op_mode=ERRORS) for line in (0, 1))
    faults = hub.bus("can0").faults
    faults.inject("crc", frame_id=1)
    sender.send(vci.CanMsg2(msg_id=1, data=b"\x01"))
    assert receiver.message(vci.CAN_MSGTYPE_ERROR).ab_data[0] == vci.CAN_ERROR_CRC
    assert receiver.message().msg_id == 1

    passive = faults.flip(bit=30, frame_id=2, times=PASSIVE_ATTEMPTS, seen_by="sender")
    sender.send(vci.CanMsg2(msg_id=2))
    assert receiver.message().msg_id == 2
    assert passive.struck == PASSIVE_ATTEMPTS
    states = [one.ab_data[0] for one in sender.waiting() if one.msg_info.type == vci.CAN_MSGTYPE_STATUS]
    assert any(state & vci.CAN_STATUS_ERRLIM for state in states)

    off = faults.flip(bit=30, frame_id=3, times=None, seen_by="sender")
    sender.send(vci.CanMsg2(msg_id=3))
    while not sender.message(vci.CAN_MSGTYPE_STATUS).ab_data[0] & vci.CAN_STATUS_BUSOFF:
        pass
    assert control.get_line_status().status & vci.CAN_STATUS_BUSOFF
    off.cancel()
    control.stop_line()
    control.start_line()
    assert receiver.message().msg_id == 3  # it had waited in the controller
    assert not control.get_line_status().status & (vci.CAN_STATUS_BUSOFF | vci.CAN_STATUS_ERRLIM)
    assert (sender.counts().lost, receiver.counts().lost) == (0, 0)


def test_vci_lin_errors(hub: Hub, vci_program: VciProgram) -> None:
    hub.plug("usb-to-can-fd", "HW000009", ("can0", "can0", "lin0"))
    slave = vci_program.lin()
    asking = vci_program.monitor("HW000009")
    master = vci_program.lin("HW000009", op_mode=vci.LIN_OPMODE_MASTER | vci.LIN_OPMODE_ERRORS)
    slave.write_message(False, vci.LinMsg(pid=1, data=b"1234", ecs=1))
    header = vci.LinMsg(pid=1, ido=1, dlen=4, ecs=1)
    faults = hub.lin_bus("lin0").faults
    for begin, error in (
        (lambda: faults.checksum(1), vci.LIN_ERROR_CHKSUM),
        (lambda: faults.no_response(1), vci.LIN_ERROR_SLNORE),
        (lambda: faults.parity(1), vci.LIN_ERROR_SLNORE),
        (lambda: faults.disconnect("HW000001:2"), vci.LIN_ERROR_SLNORE),
    ):
        fault = begin()
        master.write_message(True, header)
        hub.run_for(0.1)
        assert asking.message(vci.LIN_MSGTYPE_ERROR).ab_data[0] == error
        assert fault.struck == 1
        fault.cancel()
    master.write_message(True, header)
    assert bytes(asking.message(vci.LIN_MSGTYPE_DATA).ab_data)[:4] == b"1234"


# VCI V3


@pytest.fixture
def net(program: Programs) -> Iterator[NetProgram]:
    with contextlib.closing(NetProgram(program("a V3 program"))) as made:
        yield made


def v3_message(identifier: int) -> v3.CanMessage:
    made = v3.CanMessage()
    made.identifier = identifier
    return made


@pytest.mark.conforms("N-09")
def test_vci_v3_error_message_passive_bus_off_and_recovery(hub: Hub, net: NetProgram) -> None:
    control, _ = (net.start(line, mode=V3_BOTH | v3.CanOperatingModes.ERR_FRAME) for line in (0, 1))
    sender, receiver = net.port(0), net.port(1)
    faults = hub.bus("can0").faults
    faults.inject("crc", frame_id=1)
    sender.send(v3_message(1))
    (error,) = receiver.receive(kind=v3.CanMsgFrameType.ERROR)
    assert v3.CanMsgError(error[0]) is v3.CanMsgError.CRC
    assert [one.identifier for one in receiver.receive()] == [1]

    faults.flip(bit=30, frame_id=2, times=PASSIVE_ATTEMPTS, seen_by="sender")
    sender.send(v3_message(2))
    assert [one.identifier for one in receiver.receive()] == [2]
    told = [v3.CanCtrlStatus(one[0]) for one in sender.waiting(v3.CanMsgFrameType.STATUS)]
    assert any(v3.CanCtrlStatus.ERR_LIMIT in status for status in told)
    assert control.line_status.has_error_overrun
    assert not control.line_status.is_bus_off

    off = faults.flip(bit=30, frame_id=3, times=None, seen_by="sender")
    sender.send(v3_message(3))
    hub.run_for(0.1)
    told = [v3.CanCtrlStatus(one[0]) for one in sender.waiting(v3.CanMsgFrameType.STATUS)]
    assert v3.CanCtrlStatus.BUS_OFF in told[-1]
    assert control.line_status.is_bus_off
    off.cancel()
    control.stop_line()
    control.start_line()
    assert [one.identifier for one in receiver.receive()] == [3]  # it had waited in the controller
    assert not control.line_status.is_bus_off
    assert not control.line_status.has_error_overrun


# CANDRV


@pytest.fixture(params=["inducan104", "picocom1"])
def handle(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: Programs
) -> Iterator[Handle]:
    registry = tmp_path / "canwire.toml"
    registry.write_text(f'[candrv.CID1]\nBoard = "{request.param}"\nBaudrate = 500000\n')
    monkeypatch.setenv("CANWIRE_CONFIG", str(registry))
    with candrv.open(hub=program("a CANDRV program")) as made:
        made.accept_all()
        yield made


def kinds(handle: Handle) -> list[int]:
    return [handle.read_event().event for _ in range(handle.waiting)]


@pytest.mark.conforms("N-10")
def test_candrv_events_of_warning_passive_bus_error_and_back(hub: Hub, handle: Handle) -> None:
    peer = Program(hub, OTHER, 500_000)
    off = hub.bus("can0").faults.flip(bit=20, times=OFF_ATTEMPTS, seen_by="sender")
    handle.write("1 0 0\n")
    hub.run_for(0.1)
    steps = [event for event in kinds(handle) if event != CanbusEvent.TRANSMITTED]
    assert steps == [CanbusEvent.WARNING, CanbusEvent.PASSIVE, CanbusEvent.BUS_ERROR]
    assert off.struck == OFF_ATTEMPTS
    control(handle, ControlCode.INIT, b"", 4)
    handle.write("2 0 0\n")
    hub.run_for(0.1)
    assert 2 in [frame.id for frame in peer.frames(0)]
    assert peer.lost() == 0


# ACAN


@pytest.fixture
def driver(program: Programs) -> Iterator[acan.Driver]:
    with acan.open(program("an ACAN program")) as made:
        made.configure(acan.HardConfig())
        made.bus_on()
        yield made


@pytest.mark.conforms("N-11")
def test_acan_conditions_in_the_mirrored_block_and_return_codes(hub: Hub, driver: acan.Driver) -> None:
    peer = Program(hub, OTHER, 250_000)
    fields = ACANTB(bSCFilter=0xFF, idTable=[ACANID(0, 0, 0)])
    block = driver.register(MirroredBlock(fields))
    off = hub.bus("can0").faults.inject("bit", frame_id=1, times=None)
    seen = Condition(0)
    for attempt in range(1, OFF_ATTEMPTS):
        driver.send(Frame(1))
        hub.run_for(0.01)
        driver.pump()
        seen |= block.acknowledge().conditions
        assert fields.bTEC == 8 * attempt
    assert seen == Condition.BUSERR | Condition.ERRLIM | Condition.ERRPAS
    driver.send(Frame(1))
    hub.run_for(0.01)
    driver.pump()
    assert block.acknowledge().conditions == Condition.BUSOFF
    assert not driver.on_bus
    off.cancel()
    assert driver.bus_on() is False  # it was off the bus
    driver.send(Frame(3))
    hub.run_for(0.1)
    assert [frame.id for frame in peer.frames(0)] == [3]
    assert (block.lost, peer.lost(), off.struck) == (0, 0, OFF_ATTEMPTS)


# python-can


@pytest.mark.conforms("N-12")
def test_python_can_error_frames_and_bus_state(hub: Hub, program: Programs) -> None:
    theirs = program("a python-can program")
    with (
        can.Bus("HW000001:0", interface="canwire", hub=theirs, bitrate=500_000, error_frames=True) as sender,
        can.Bus("HW000001:1", interface="canwire", hub=theirs, bitrate=500_000, error_frames=True) as reader,
    ):
        faults = hub.bus("can0").faults
        faults.inject("crc", frame_id=1)
        sender.send(can.Message(arbitration_id=1, is_extended_id=False))
        first, second = reader.recv(1), reader.recv(1)
        assert first is not None
        assert first.is_error_frame
        assert second is not None
        assert second.arbitration_id == 1

        faults.flip(bit=30, frame_id=2, times=PASSIVE_ATTEMPTS + 1, seen_by="sender")
        sender.send(can.Message(arbitration_id=2, is_extended_id=False))
        hub.run_for(0.01)
        told = []
        while (message := sender.recv(0)) is not None:
            told.append(message)
        assert any(
            one.arbitration_id & CAN_ERR_CRTL and one.data[1] & CAN_ERR_CRTL_TX_PASSIVE for one in told
        )

        off = faults.flip(bit=30, frame_id=3, times=None, seen_by="sender")
        sender.send(can.Message(arbitration_id=3, is_extended_id=False))
        hub.run_for(0.1)
        assert sender.state is can.BusState.ERROR
        while sender.recv(0) is not None:
            pass
        with pytest.raises(can.CanOperationError, match="bus-off"):
            sender.send(can.Message(arbitration_id=4, is_extended_id=False))
        off.cancel()
        sender.state = can.BusState.ACTIVE
        sender.send(can.Message(arbitration_id=5, is_extended_id=False))
        heard = []
        while (message := reader.recv(0.1)) is not None:
            if not message.is_error_frame:
                heard.append(message.arbitration_id)
        assert (heard[-1], sender.state) == (5, can.BusState.ACTIVE)
        assert hub.line_status(hub.board("HW000001").id, 1).lost == 0


@pytest.mark.conforms("N-07")
def test_a_noisy_bus_loses_time_and_no_frame_of_any_program(hub: Hub, program: Programs) -> None:
    receivers = [Program(program("a"), OTHER), Program(program("b"), SJA1000), Program(program("c"), MCP2515)]
    sender = Program(program("sender"), "HW000001:0")
    noise = hub.bus("can0").faults.noise(1e-3)
    for number in range(200):
        sender.send(Frame(0x100 + number, bytes(4)))
        hub.run_for(0.002)
    hub.run_for(0.5)
    assert noise.struck > 10
    for receiver in receivers:
        heard = {frame.id for frame in receiver.frames(0)}
        assert heard == {0x100 + number for number in range(200)}
        assert receiver.lost() == 0
