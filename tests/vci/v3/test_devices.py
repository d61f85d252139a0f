"""The device list, its events and enumerators, and what a board tells of itself."""

from __future__ import annotations

from typing import Any
from uuid import UUID

import pytest

from canwire import vci
from canwire.vci import v3
from tests.vci.v3.programs import NetProgram

BOARDS = ["HW000001", "HW000002"]
LONG_MS = 30_000


@pytest.fixture
def devices(hub: Any) -> Any:
    with v3.VciServer.get_device_manager() as manager, manager.get_device_list() as made:
        yield made


def hardware_ids(devices: Any) -> list[Any]:
    return [device.unique_hardware_id for device in devices]


@pytest.mark.conforms("X3-01")
def test_the_list_tells_what_each_board_is(devices: Any) -> None:
    fd, classic = devices
    assert (fd.unique_hardware_id, classic.unique_hardware_id) == tuple(BOARDS)
    assert "USB-to-CAN FD" in fd.description
    assert fd.device_class == vci.GUID_USB2CAN_FD_DEVICE
    assert classic.device_class == vci.GUID_USB2CAN_V2_DEVICE
    assert isinstance(fd.device_class, UUID)
    assert fd.vci_object_id != classic.vci_object_id
    assert fd.manufacturer
    for version in (fd.driver_version, fd.hardware_version):
        assert str(version) == ".".join(map(str, version))
        assert len(version) == 4
    can = v3.VciBusType.CAN
    lin = (v3.VciBusType.LIN, vci.LIN_CTRL_GENERIC)
    assert fd.equipment == [(can, v3.CanCtrlType.IFI_CAN_FD)] * 2 + [lin]
    assert classic.equipment == [(can, v3.CanCtrlType.BXCAN)] * 2


def test_the_server_is_one(hub: Any) -> None:
    assert v3.VciServer.instance() is v3.VciServer.instance()
    with v3.VciServer.instance().device_manager as manager, manager.get_device_list() as devices:
        assert hardware_ids(devices) == BOARDS


@pytest.mark.conforms("X3-02", "X3-03")
def test_boards_come_and_go(devices: Any, hub: Any) -> None:
    event = v3.AutoResetEvent()
    devices.assign_event(event)
    hub.plug("usb-to-can", "HW777777")
    try:
        assert event.wait_one(LONG_MS)
        assert not event.is_set()
        assert hardware_ids(devices) == [*BOARDS, "HW777777"]
    finally:
        hub.unplug("HW777777")
    assert event.wait_one(LONG_MS)
    assert not event.is_set()
    assert hardware_ids(devices) == BOARDS
    devices.assign_event(None)
    event.close()


@pytest.mark.conforms("X3-01")
def test_a_board_gets_another_object_id_at_each_login_but_keeps_its_hardware_id(
    devices: Any, hub: Any
) -> None:
    hub.plug("usb-to-can", "HW777777")
    before = list(devices)[-1]
    hub.unplug("HW777777")
    hub.plug("usb-to-can", "HW777777")
    try:
        after = list(devices)[-1]
        assert before.unique_hardware_id == after.unique_hardware_id == "HW777777"
        assert before.vci_object_id != after.vci_object_id
    finally:
        hub.unplug("HW777777")


@pytest.mark.conforms("X3-04")
def test_enumerators_are_independent(devices: Any) -> None:
    one, other = devices.get_enumerator(), devices.get_enumerator()
    assert one.move_next()
    assert one.move_next()
    assert other.move_next()
    assert [each.current.unique_hardware_id for each in (one, other)] == [BOARDS[1], BOARDS[0]]
    assert not one.move_next()
    assert not one.move_next()
    one.reset()
    assert one.move_next()
    assert one.current.unique_hardware_id == BOARDS[0]
    assert one.current is not one.current


@pytest.mark.finding("vendor 4")
def test_objects_of_the_same_board_are_equal(devices: Any) -> None:
    """Current gives a new object (manual 2.2), and programs compare what two calls gave."""
    enumerator = devices.get_enumerator()
    enumerator.move_next()
    first = enumerator.current
    assert first == enumerator.current
    assert len({first, enumerator.current}) == 1
    enumerator.move_next()
    assert first != enumerator.current
    assert first != first.vci_object_id


@pytest.mark.finding("vendor 3")
def test_before_the_first_and_behind_the_last_there_is_no_current(devices: Any) -> None:
    enumerator = devices.get_enumerator()
    for _ in range(2):
        with pytest.raises(v3.InvalidOperationException) as raised:
            enumerator.current  # noqa: B018
        assert raised.value.code == vci.VCI_E_INVALID_STATE
        while enumerator.move_next():
            pass


def test_a_board_that_was_pulled_out_cannot_be_opened(devices: Any, hub: Any) -> None:
    hub.plug("usb-to-can", "HW777777")
    device = list(devices)[-1]
    hub.unplug("HW777777")
    assert device.unique_hardware_id == "HW777777"
    with pytest.raises(v3.VciException) as raised:
        device.open_bus_access_layer()
    assert raised.value.code == vci.VCI_E_DEVICE_NOT_CONNECTED


def test_what_is_disposed_is_of_no_use(devices: Any) -> None:
    device = next(iter(devices))
    enumerator = devices.get_enumerator()
    for one in (device, enumerator, devices):
        one.dispose()
        one.dispose()
    for use in (
        lambda: device.description,
        device.open_bus_access_layer,
        enumerator.move_next,
        devices.get_enumerator,
    ):
        with pytest.raises(v3.ObjectDisposedException):
            use()


def test_what_was_got_from_them_outlives_manager_list_and_device(hub: Any) -> None:
    with v3.VciServer.get_device_manager() as manager, manager.get_device_list() as devices:
        device = next(iter(devices))
    with device, device.open_bus_access_layer() as bal:
        socket = bal.open_socket(0, v3.CanSocket)
    with socket:
        assert socket.line_status.is_in_init_mode


# the access layer


@pytest.mark.conforms("X3-05")
def test_programs_share_the_access_layer_and_no_other_layer_opens_beside_it(
    net: NetProgram, other_net: NetProgram, hub: Any
) -> None:
    board = hub.board("HW000001").id
    with net.bal() as one, other_net.bal() as other:
        assert one.resources.count == other.resources.count == 3
        with pytest.raises(Exception, match="layer"):
            hub.open_layer(board, "canopen")
    with hub.open_layer(board, "canopen"), net.device() as device:
        with pytest.raises(v3.VciException) as raised:
            device.open_bus_access_layer()
        assert raised.value.code == vci.VCI_E_ACCESSDENIED
    net.bal().dispose()


@pytest.mark.conforms("X3-06")
def test_the_access_layer_lists_the_connectors(net: NetProgram) -> None:
    bal = net.bal()
    assert bal.firmware_version.major >= 1
    assert [(one.bus_port, one.bus_type, one.bus_name) for one in bal.resources] == [
        (0, v3.VciBusType.CAN, "CAN-1"),
        (1, v3.VciBusType.CAN, "CAN-2"),
        (2, v3.VciBusType.LIN, "LIN-1"),
    ]
    assert len(bal.resources) == bal.resources.count == 3
    assert bal.resources[1].bus_name == "CAN-2"
    with pytest.raises(v3.ArgumentOutOfRangeException):
        bal.resources[3]


@pytest.mark.conforms("X3-06")
@pytest.mark.parametrize("kind", [v3.CanSocket, v3.CanChannel, v3.CanControl, v3.CanScheduler])
def test_sockets_open_on_every_connector_of_their_bus_and_on_no_other(net: NetProgram, kind: Any) -> None:
    bal = net.bal()
    for port in (0, 1):
        with bal.open_socket(port, kind) as socket:
            assert type(socket) is kind
            assert (socket.bus_port, socket.bus_name) == (port, f"CAN-{port + 1}")
    with pytest.raises(v3.NotImplementedException):
        bal.open_socket(2, kind)
    for port in (-1, bal.resources.count):
        with pytest.raises(IndexError) as raised:
            bal.open_socket(port, kind)
        assert isinstance(raised.value, v3.VciException)


@pytest.mark.conforms("X3-06")
@pytest.mark.parametrize("kind", [int, v3.BalObject, "ICanSocket", None])
def test_other_interfaces_are_not_implemented(net: NetProgram, kind: Any) -> None:
    with pytest.raises(v3.NotImplementedException):
        net.bal().open_socket(0, kind)


# the socket


@pytest.mark.conforms("X3-07")
def test_any_number_of_programs_look_at_a_line(net: NetProgram, other_net: NetProgram) -> None:
    sockets = [one.open(v3.CanSocket) for one in (net, net, other_net)]
    control = net.control(mode=v3.CanOperatingModes.STANDARD | v3.CanOperatingModes.LISTEN_ONLY)
    for socket in sockets:
        status = socket.line_status
        assert status.is_in_init_mode
        assert status.is_mode_standard
        assert status.is_listen_only
        assert not status.is_mode_extended
        assert status.bitrate == v3.CanBitrate.CIA_500_KBIT
    control.start_line()
    assert [socket.line_status.is_in_init_mode for socket in sockets] == [False] * 3
    for name in ("init_line", "start_line", "activate"):
        assert not hasattr(v3.CanSocket, name)


@pytest.mark.conforms("X3-07")
def test_a_socket_tells_what_the_line_can(net: NetProgram) -> None:
    socket = net.open(v3.CanSocket)
    assert socket.controller_type is v3.CanCtrlType.IFI_CAN_FD
    assert socket.bus_coupling == v3.CanBusCouplings.HIGH_SPEED
    assert v3.CanFeatures.CAN_FD in socket.features
    assert socket.features < 0x2000
    for name in ("std_and_ext_frames", "remote_frames", "error_frames", "bus_load_computation"):
        assert getattr(socket, f"supports_{name}") is True
    for name in (
        "exact_message_filter",
        "listen_only_mode",
        "cyclic_message_scheduler",
        "delayed_transmission",
    ):
        assert getattr(socket, f"supports_{name}") is True
    for name in ("std_or_ext_frames", "error_frame_generation"):
        assert getattr(socket, f"supports_{name}") is False


@pytest.mark.conforms("X3-07")
def test_a_classic_line_has_no_can_fd(net: NetProgram) -> None:
    socket = net.open(v3.CanSocket, board="HW000002")
    assert v3.CanFeatures.CAN_FD not in socket.features
    assert socket.controller_type is v3.CanCtrlType.BXCAN


@pytest.mark.conforms("X3-25", "X3-30", "X3-34")
def test_ticks_follow_from_clock_and_divisors(net: NetProgram, hub: Any) -> None:
    facts = hub.board("HW000001").lines[0].capabilities
    socket = net.open(v3.CanSocket)
    clock = socket.clock_frequency
    assert socket.time_stamp_counter_divisor * 10**9 / clock == facts.stamps.tick_ns
    assert socket.delayed_tx_timer_divisor * 10**9 / clock == facts.delay.tick_ns
    assert socket.cyclic_message_timer_divisor * 10**9 / clock == facts.cyclic.tick_ns
    assert socket.max_delayed_tx_ticks == facts.delay.maximum
    assert socket.max_cyclic_message_ticks == facts.cyclic.maximum
    assert socket.max_cyclic_msg_ticks == socket.max_cyclic_message_ticks
    assert socket.cyclic_message_time_divisor == socket.cyclic_message_timer_divisor


@pytest.mark.finding("vendor 1")
def test_a_resource_can_be_disposed_and_still_be_read(net: NetProgram) -> None:
    bal = net.bal()
    for resource in bal.resources:
        with resource as same:
            assert same is resource
        resource.dispose()
        assert resource.bus_name == bal.resources[resource.bus_port].bus_name
    assert isinstance(bal.resources[0], v3.IDisposable)


@pytest.mark.finding("vendor 1")
@pytest.mark.parametrize("kind", [v3.CanControl, v3.CanScheduler])
def test_a_socket_gives_back_what_it_holds_when_it_is_disposed_as_a_resource(
    net: NetProgram, kind: Any
) -> None:
    """Each of these may be opened once: the second one shows that the first one's lease is gone."""
    resource: v3.IBalResource = net.open(kind)
    with pytest.raises(v3.VciException):
        net.open(kind)
    with resource:
        pass
    net.open(kind).dispose()
    net.open(kind)


def test_a_disposed_socket_tells_nothing(net: NetProgram) -> None:
    socket = net.open(v3.CanSocket)
    socket.dispose()
    for name in ("line_status", "clock_frequency", "features", "supports_remote_frames"):
        with pytest.raises(v3.ObjectDisposedException):
            getattr(socket, name)
