"""A board that is pulled out under open objects, and plugged in again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from canwire import vci
from canwire.vci import v3
from tests.hubs import until
from tests.vci.programs import Virtual
from tests.vci.v3.programs import NetProgram

BOARD = "HW888888"


@pytest.fixture
def pulled(net: NetProgram, hub: Any) -> Any:
    """Uses of every kind of object on a board that is not there any more."""
    hub.plug("usb-to-can-fd", BOARD)
    bal, device = net.bal(BOARD), net.device(BOARD)
    control, port = net.start(0, BOARD), net.port(0, BOARD)
    socket, scheduler = net.open(v3.CanSocket, 1, BOARD), net.open(v3.CanScheduler, 0, BOARD)
    hub.unplug(BOARD)
    return {
        "device": device.open_bus_access_layer,
        "equipment": lambda: device.equipment,
        "access layer": lambda: bal.resources,
        "opening": lambda: bal.open_socket(0, v3.CanSocket),
        "socket": lambda: socket.line_status,
        "facts": lambda: socket.clock_frequency,
        "control": control.start_line,
        "filter": lambda: control.set_acc_filter(v3.CanFilter.STD, 0, 0),
        "channel": port.channel.activate,
        "channel status": lambda: port.channel.channel_status,
        "reader": port.reader.read_message,
        "many": lambda: port.reader.read_messages(5),
        "fill count": lambda: port.reader.fill_count,
        "writer": lambda: port.writer.send_message(v3.CanMessage()),
        "list": scheduler.resume,
        "list status": scheduler.update_status,
    }


def error_of(use: Callable[[], object]) -> v3.VciException | None:
    try:
        use()
    except v3.VciException as error:
        return error
    return None


def refused(use: Callable[[], object]) -> v3.VciException:
    """What it raises once this program has heard that the board is gone: a moment after it was pulled."""
    until(lambda: error_of(use))
    error = error_of(use)
    assert error is not None
    return error


@pytest.mark.conforms("X3-35")
def test_every_object_says_that_the_board_is_gone(pulled: Any) -> None:
    for name, use in pulled.items():
        assert refused(use).code == vci.VCI_E_DEVICE_NOT_CONNECTED, name


@pytest.mark.conforms("X3-35")
def test_the_board_opens_again_by_its_hardware_id(
    pulled: Any, net: NetProgram, hub: Any, message: Any
) -> None:
    hub.plug("usb-to-can-fd", BOARD)
    try:
        net.start(0, BOARD)
        net.start(1, BOARD)
        sender, receiver = net.port(0, BOARD), net.port(1, BOARD)
        sender.send(message(0x42))
        assert receiver.receive()[0].identifier == 0x42
        for use in pulled.values():
            refused(use)
    finally:
        hub.unplug(BOARD)


def test_a_lost_hub_is_another_error(virtual: Virtual, virtual_net: NetProgram) -> None:
    control, port = virtual_net.start(), virtual_net.port()
    virtual.engine.close()
    for use in (control.stop_line, port.reader.read_message, lambda: control.line_status):
        with pytest.raises(v3.VciException) as raised:
            use()
        assert raised.value.code == vci.VCI_E_DISCONNECTED


def test_with_its_connection_a_program_disposes_everything(net: NetProgram, hub: Any) -> None:
    control, port = net.start(), net.port()
    hub.close()
    for use in (control.stop_line, port.reader.read_message, lambda: control.line_status):
        with pytest.raises(v3.ObjectDisposedException):
            use()
