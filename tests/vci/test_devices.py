"""The list of devices, devices, and the access layer of a board."""

from __future__ import annotations

import subprocess
import sys
import uuid
from typing import Any

import pytest

import canwire
from canwire import vci
from tests.hubs import Connect, Served
from tests.vci.programs import Program

FD_BOARD, CLASSIC_BOARD = "HW000001", "HW000002"
NEW_BOARD = "HW777777"
FD_CLASS, CLASSIC_CLASS = vci.GUID_USB2CAN_FD_DEVICE, vci.GUID_USB2CAN_V2_DEVICE


@pytest.fixture
def new_board(hub: canwire.Hub) -> Any:
    """Plugs in a board that is pulled out in the end."""
    made = []

    def plug() -> canwire.BoardInfo:
        made.append(hub.plug("usb-to-can-fd", NEW_BOARD))
        return made[-1]

    yield plug
    if any(board.hardware_id == NEW_BOARD for board in hub.boards()):
        hub.unplug(NEW_BOARD)


def hardware_ids(infos: list[vci.VciDeviceInfo]) -> list[Any]:
    return [info.hardware_id for info in infos]


# before everything else


@pytest.mark.conforms("X4-01")
def test_everything_else_wants_initialize_first(source_directory: str) -> None:
    script = """
from canwire import vci
calls = [vci.get_device_manager, vci.create_luid, lambda: vci.query_device_by_hwid("HW000001"),
         lambda: vci.query_device_by_class(vci.GUID_USB2CAN_FD_DEVICE, 0),
         lambda: vci.create_fifo(10, 10, vci.IID_IVciFifo), lambda: vci.access_fifo(vci.VciId(1), vci.IID_IVciFifo)]
for call in calls:
    try:
        call()
    except vci.VciNotInitialized as error:
        print(error.code == vci.VCI_E_NOT_INITIALIZED)
vci.get_version(), vci.format_error(vci.VCI_E_FAIL), vci.luid_to_char(vci.VciId(1))
"""
    command = [sys.executable, "-c", script]
    done = subprocess.run(
        command, capture_output=True, text=True, check=True, env={"PYTHONPATH": source_directory}
    )
    assert done.stdout.split() == ["True"] * 6


@pytest.mark.conforms("X4-01")
def test_initialising_again_changes_nothing(hub: canwire.Hub) -> None:
    before = vci.create_luid()
    vci.initialize()
    assert vci.create_luid() != before
    with vci.get_device_manager() as manager:
        assert manager._hub is hub


def test_a_hub_that_does_not_answer(tmp_path: Any) -> None:
    with pytest.raises(vci.VciDisconnected):
        vci.initialize(str(tmp_path / "nobody.sock"))


@pytest.mark.conforms("X4-02")
def test_version() -> None:
    version = vci.get_version()
    assert (version.vci_major_version, version.vci_minor_version) == (4, 0)
    numbers = [int(number) for number in canwire.__version__.split(".")[:3]]
    assert (version.vci_rev_number, version.vci_build_number) == (numbers[0] * 100 + numbers[1], numbers[2])
    assert version.os_major_version > 0
    assert vci.VciVersionInfo.from_bytes(version.to_bytes()) == version


def test_luids_are_unique(hub: canwire.Hub) -> None:
    made = {vci.create_luid().as_int64 for _ in range(20)}
    assert len(made) == 20


# the list


@pytest.mark.conforms("X3-01")
def test_the_list_describes_every_board(program: Program) -> None:
    with program.manager.enum_devices() as devices:
        first, second = devices.next(10)
    assert (first.hardware_id, second.hardware_id) == (FD_BOARD, CLASSIC_BOARD)
    assert (first.device_class, second.device_class) == (FD_CLASS, CLASSIC_CLASS)
    assert first.vci_object_id != second.vci_object_id
    assert "USB-to-CAN FD" in first.description
    assert first.manufacturer
    assert first.driver_major_version == 4
    assert (first.hardware_major_version, first.hardware_minor_version) == (1, 0)
    assert vci.VciDeviceInfo.from_bytes(first.to_bytes()) == first


@pytest.mark.conforms("X4-05", "X3-04")
def test_going_through_the_list(program: Program) -> None:
    with program.manager.enum_devices() as devices:
        assert hardware_ids(devices.next(1)) == [FD_BOARD]
        assert hardware_ids(devices.next(5)) == [CLASSIC_BOARD]
        for count in (1, 5):
            with pytest.raises(vci.VciNoMoreItems):
                devices.next(count)
        assert devices.next(0) == []
        devices.reset()
        devices.skip(1)
        assert hardware_ids(devices.next()) == [CLASSIC_BOARD]
        devices.reset()
        assert hardware_ids(list(devices)) == [FD_BOARD, CLASSIC_BOARD]
        assert list(devices) == []
        devices.reset()
        devices.skip(10)
        with pytest.raises(vci.VciNoMoreItems):
            devices.next(1)
        with pytest.raises(vci.VciInvalidArgument):
            devices.next(-1)


@pytest.mark.conforms("X4-05", "X3-04")
def test_looks_through_the_list_are_independent(program: Program) -> None:
    with program.manager.enum_devices() as one, program.manager.enum_devices() as other:
        assert hardware_ids(one.next(1)) == hardware_ids(other.next(1)) == [FD_BOARD]
        one.reset()
        assert hardware_ids(other.next(1)) == [CLASSIC_BOARD]
        assert hardware_ids(one.next(1)) == [FD_BOARD]


@pytest.mark.conforms("X3-02")
def test_boards_come_and_go(program: Program, new_board: Any) -> None:
    with program.manager.enum_devices() as devices:
        assert len(devices.next(10)) == 2
        new_board()
        assert hardware_ids(devices.next(10)) == [NEW_BOARD]
        program.hub.unplug(NEW_BOARD)
        devices.reset()
        assert hardware_ids(devices.next(10)) == [FD_BOARD, CLASSIC_BOARD]


@pytest.mark.conforms("X3-03", "X4-05")
def test_an_event_comes_with_each_change(program: Program, new_board: Any, event: canwire.Event) -> None:
    other = canwire.Event()
    with program.manager.enum_devices() as one, program.manager.enum_devices() as two:
        one.assign_event(event)
        two.assign_event(other)
        assert not event.wait(0)
        new_board()
        assert event.wait(30)
        assert other.wait(30)
        assert not event.is_set()
        program.hub.unplug(NEW_BOARD)
        assert event.wait(30)
        assert other.wait(30)
        one.assign_event(None)
    other.close()


# a device


@pytest.mark.conforms("X4-06")
def test_opening_a_device(program: Program) -> None:
    with program.manager.enum_devices() as devices:
        for info in devices:
            with program.manager.open_device(info.vci_object_id) as device:
                assert device.get_device_info() == info
    with pytest.raises(vci.VciNoSuchDevice):
        program.manager.open_device(vci.VciId(0x7FFF_FFFF))
    with pytest.raises(vci.VciInvalidArgument):
        program.manager.open_device("HW000001")


@pytest.mark.conforms("X4-06")
@pytest.mark.parametrize(
    "hwid",
    [
        CLASSIC_BOARD,
        b"HW000002",
        b"HW000002".ljust(16, b"\0"),
        uuid.UUID(bytes_le=b"HW000002".ljust(16, b"\0")),
    ],
)
def test_a_device_by_its_hardware_id(hub: canwire.Hub, hwid: Any) -> None:
    with vci.query_device_by_hwid(hwid) as device:
        assert device.get_device_info().hardware_id == CLASSIC_BOARD


@pytest.mark.conforms("X4-06")
def test_no_device_by_that_hardware_id(hub: canwire.Hub) -> None:
    for hwid in ("HW999999", uuid.UUID(int=1)):
        with pytest.raises(vci.VciNoSuchDevice):
            vci.query_device_by_hwid(hwid)
    for wrong in ("", "HW3456789012345678", b""):
        with pytest.raises(vci.VciInvalidArgument):
            vci.query_device_by_hwid(wrong)


@pytest.mark.conforms("X4-06")
def test_a_device_by_its_class(hub: canwire.Hub, new_board: Any) -> None:
    new_board()
    for device_class, instance, hardware_id in (
        (FD_CLASS, 0, FD_BOARD),
        (FD_CLASS, 1, NEW_BOARD),
        (CLASSIC_CLASS, 0, CLASSIC_BOARD),
    ):
        with vci.query_device_by_class(device_class, instance) as device:
            assert device.get_device_info().hardware_id == hardware_id
    for device_class, instance in ((FD_CLASS, 2), (vci.GUID_CANBRIDGE_DEVICE, 0)):
        with pytest.raises(vci.VciNoSuchDevice):
            vci.query_device_by_class(device_class, instance)
    with pytest.raises(vci.VciInvalidArgument):
        vci.query_device_by_class(FD_CLASS, -1)


@pytest.mark.conforms("X4-07", "X3-01", "X3-06")
@pytest.mark.parametrize(
    ("board", "types"),
    [
        (FD_BOARD, [vci.vci_bus_ctrl(vci.VCI_BUS_CAN, vci.CAN_CTRL_IFICFD)] * 2 + [vci.VCI_LIN_GENERIC]),
        (CLASSIC_BOARD, [vci.vci_bus_ctrl(vci.VCI_BUS_CAN, vci.CAN_CTRL_BXCAN)] * 2),
    ],
)
def test_equipment(program: Program, board: str, types: list[int]) -> None:
    caps = program.device(board).get_device_caps()
    features = program.bal(board).get_features()
    assert caps.bus_ctrl_count == features.bus_socket_count == len(types)
    assert caps.bus_ctrl_types == features.bus_socket_type == types + [0] * (32 - len(types))
    assert features.fw_major_version >= 1


# the access layer


@pytest.mark.conforms("X3-05")
def test_the_bal_opens_by_two_names_and_for_everybody(program: Program, other_program: Program) -> None:
    device = program.device()
    for iid in (vci.IID_IBalObject, vci.IID_IUnknown):
        with device.open_component(vci.CLSID_VCIBAL, iid) as bal:
            assert isinstance(bal, vci.BalObject)
            assert other_program.bal().get_features() == bal.get_features()
    with pytest.raises(vci.VciNoInterface):
        device.open_component(vci.CLSID_VCIBAL, vci.IID_ICanSocket)
    with pytest.raises(vci.VciNotImplemented):
        device.open_component(uuid.UUID(int=5), vci.IID_IBalObject)


@pytest.mark.conforms("X3-05")
def test_another_layer_of_the_board_keeps_the_bal_away(program: Program, other_program: Program) -> None:
    device = program.device()
    board = other_program.hub.board(FD_BOARD).id
    with other_program.hub.open_layer(board, "another"), pytest.raises(vci.VciAccessDenied):
        device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
    with device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject), pytest.raises(canwire.InUse):
        other_program.hub.open_layer(board, "another")
    other_program.hub.open_layer(board, "another").close()


@pytest.mark.conforms("X3-05")
@pytest.mark.parametrize("iid", [vci.IID_ICanSocket, vci.IID_ICanControl2, vci.IID_ICanScheduler])
def test_the_bal_stays_open_for_what_was_opened_from_it(program: Program, iid: Any) -> None:
    board = program.hub.board(FD_BOARD).id
    bal = program.device().open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
    opened = bal.open_socket(0, iid)
    assert bal.release() == 0
    with pytest.raises(canwire.InUse):
        program.hub.open_layer(board, "another")
    if iid == vci.IID_ICanSocket:
        channel = opened.create_channel(False)
        assert opened.release() == 0
        with pytest.raises(canwire.InUse):
            program.hub.open_layer(board, "another")
        opened = channel
    assert opened.release() == 0
    program.hub.open_layer(board, "another").close()


@pytest.mark.conforms("X3-06")
def test_connectors_have_numbers(program: Program) -> None:
    bal = program.bal()
    for number in (0, 1):
        with bal.open_socket(number, vci.IID_ICanSocket2) as socket:
            info = socket.get_socket_info()
            assert (info.socket_no, vci.vci_bus_type(info.bus_type)) == (number, vci.VCI_BUS_CAN)
    for wrong in (3, -1, 1 << 40, "0"):
        with pytest.raises(vci.VciInvalidIndex):
            bal.open_socket(wrong, vci.IID_ICanSocket2)


@pytest.mark.conforms("X3-06")
def test_connectors_have_interfaces(program: Program) -> None:
    bal = program.bal()
    kinds = {
        vci.IID_ICanSocket: vci.CanSocket,
        vci.IID_ICanSocket2: vci.CanSocket2,
        vci.IID_ICanControl: vci.CanControl,
        vci.IID_ICanControl2: vci.CanControl2,
        vci.IID_ICanScheduler: vci.CanScheduler,
        vci.IID_ICanScheduler2: vci.CanScheduler2,
    }
    for iid, kind in kinds.items():
        with bal.open_socket(0, iid) as opened:
            assert type(opened) is kind
            assert opened.query_interface(iid) is opened
            opened.release()
    for absent in (vci.IID_ILinSocket, vci.IID_ILinControl, vci.IID_ICanStatus, vci.IID_ICanChannel):
        with pytest.raises(vci.VciNotImplemented):
            bal.open_socket(0, absent)
    for unknown in (vci.IID_IVciDevice, vci.IID_IUnknown, uuid.UUID(int=9)):
        with pytest.raises(vci.VciNoInterface):
            bal.open_socket(0, unknown)


@pytest.mark.conforms("X3-07")
def test_sockets_are_for_everybody(program: Program, other_program: Program) -> None:
    control = program.start(0)
    sockets = [one.open(vci.IID_ICanSocket2) for one in (program, other_program, program, other_program)]
    for socket in sockets:
        assert socket.get_capabilities().can_clk_freq == 80_000_000
        assert socket.get_line_status().status & vci.CAN_STATUS_ININIT == 0
    control.stop_line()
    for socket in sockets:
        assert socket.get_line_status().status & vci.CAN_STATUS_ININIT
        assert not hasattr(socket, "start_line")


# pulled out


@pytest.mark.conforms("X3-35")
def test_a_board_pulled_out_says_so_on_every_handle(
    program: Program, new_board: Any, event: canwire.Event
) -> None:
    new_board()
    device, bal = program.device(NEW_BOARD), program.bal(NEW_BOARD)
    socket, port = program.open(vci.IID_ICanSocket2, 0, NEW_BOARD), program.port(0, NEW_BOARD)
    control = program.start(0, NEW_BOARD)
    scheduler = program.open(vci.IID_ICanScheduler2, 0, NEW_BOARD)
    port.message(vci.CAN_MSGTYPE_INFO)
    port.reader.assign_event(event)
    program.hub.unplug(NEW_BOARD)
    assert event.wait(30)
    calls = [
        device.get_device_info,
        device.get_device_caps,
        lambda: device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject),
        bal.get_features,
        lambda: bal.open_socket(0, vci.IID_ICanSocket),
        socket.get_capabilities,
        socket.get_line_status,
        lambda: socket.create_channel(False),
        port.channel.get_status,
        port.channel.deactivate,
        port.channel.get_control,
        port.reader.get_fill_count,
        port.reader.acquire_read,
        lambda: port.send(vci.CanMsg2(msg_id=1)),
        control.stop_line,
        control.get_line_status,
        lambda: control.init_line(program.init()),
        scheduler.get_status,
        scheduler.resume,
    ]
    for call in calls:
        with pytest.raises(vci.VciDeviceNotConnected):
            call()


@pytest.mark.conforms("X3-35")
def test_plugged_in_again_it_is_found_by_its_hardware_id(program: Program, new_board: Any) -> None:
    first = new_board()
    with program.manager.enum_devices() as devices:
        old = devices.next(3)[-1].vci_object_id
    program.hub.unplug(NEW_BOARD)
    assert new_board().id != first.id
    with pytest.raises(vci.VciNoSuchDevice):
        program.manager.open_device(old)
    with vci.query_device_by_hwid(NEW_BOARD) as device:
        assert device.get_device_info().vci_object_id != old
        with device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject) as bal:
            assert bal.get_features().bus_socket_count == 3


@pytest.mark.conforms("X3-35")
def test_when_the_hub_dies_every_handle_is_disconnected(
    mortal_program: Program, mortal_hub: Served, event: canwire.Event
) -> None:
    program, (_, process) = mortal_program, mortal_hub
    device, bal, port = program.device(), program.bal(), program.port(0)
    control, scheduler = program.start(0), program.open(vci.IID_ICanScheduler)
    port.message(vci.CAN_MSGTYPE_INFO)
    port.waiting()
    port.reader.assign_event(event)
    process.kill()
    assert event.wait(30)
    calls = [
        program.manager.enum_devices().next,
        device.get_device_info,
        bal.get_features,
        lambda: bal.open_socket(0, vci.IID_ICanSocket),
        port.channel.get_status,
        port.reader.get_data_entry,
        port.writer.acquire_write,
        control.start_line,
        scheduler.resume,
    ]
    for call in calls:
        with pytest.raises(vci.VciDisconnected):
            call()


@pytest.mark.conforms("X3-35")
def test_after_closing_the_connection_every_handle_is_dead(connect: Connect) -> None:
    hub = connect("short-lived")
    manager = vci.VciDeviceManager(hub)
    with manager.enum_devices() as devices:
        device = manager.open_device(devices.next()[0].vci_object_id)
        bal = device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
        socket = bal.open_socket(0, vci.IID_ICanSocket)
        hub.close()
        calls = [manager.enum_devices().next, devices.next, device.get_device_info]
        for call in calls:
            with pytest.raises(vci.VciDisconnected):
                call()
    for call in (bal.get_features, socket.get_line_status):
        with pytest.raises(vci.VciError) as raised:
            call()
        assert raised.value.code in (vci.VCI_E_DISCONNECTED, vci.VCI_E_INVHANDLE)
    assert [socket.release(), bal.release(), device.release()] == [0, 0, 0]
