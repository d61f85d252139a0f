"""Rows of docs/porting-vci.md's differences that no other test shows."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import canwire
from canwire import vci
from canwire.vci import v3
from canwire.vci.fifo.elements import Plain
from tests.vci.fifo.test_fifo import Pair


@pytest.fixture
def bal() -> Iterator[Any]:
    """The access layer of a USB-to-CAN FD, on a hub in virtual time."""
    with canwire.connect(time="virtual") as hub:
        vci.initialize(hub)
        with vci.query_device_by_class(vci.GUID_USB2CANFD_DEVICE) as device:
            yield device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)


def test_figures(bal: Any) -> None:
    caps = bal.open_socket(0, vci.IID_ICanSocket2).get_capabilities()
    assert caps.can_clk_freq == 80_000_000
    assert caps.tsc_divisor / caps.tsc_clk_freq == 1e-6
    assert caps.cms_divisor / caps.cms_clk_freq == caps.dtx_divisor / caps.dtx_clk_freq == 100e-6
    assert caps.cms_max_ticks == caps.dtx_max_ticks == 65_535


def test_interfaces_of_the_headers_alone(bal: Any) -> None:
    for iid in (vci.IID_ICanStatus, vci.IID_ICanObject):
        with pytest.raises(vci.VciNotImplemented):
            bal.open_socket(0, iid)


def test_a_classic_message_with_a_dlc_beyond_8(bal: Any) -> None:
    ends = []
    for connector in (0, 1):
        channel = bal.open_socket(connector, vci.IID_ICanSocket).create_channel()
        channel.initialize(10, 10)
        channel.activate()
        control = bal.open_socket(connector, vci.IID_ICanControl)
        init = vci.CanInitLine(vci.CAN_OPMODE_STANDARD, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)
        control.init_line(init)
        control.start_line()
        ends.append(channel)
    event, reader = canwire.Event(), ends[1].get_reader()
    reader.assign_event(event)
    ends[0].get_writer().put_data_entry(vci.CanMsg(msg_id=1, data=b"12345678", dlc=15))
    message = vci.CanMsg(type=vci.CAN_MSGTYPE_INFO)
    while message.msg_info.type != vci.CAN_MSGTYPE_DATA:
        assert reader.get_fill_count() or event.wait(1.0)
        message = reader.get_data_entry()
    assert (message.msg_info.dlc, message.data) == (15, b"12345678")


@pytest.mark.parametrize("released", [False, True], ids=["taken off", "reader released"])
def test_a_signalled_event_loses_its_signal_with_its_fifo(released: bool) -> None:
    pair, event = Pair(Plain(4)), canwire.Event()
    pair.reader.assign_event(event)
    pair.fill(1)
    assert event.is_set()
    if released:
        pair.reader.release()
    else:
        pair.reader.assign_event(None)
    assert not event.is_set()
    event.close()


def test_names_that_are_missing() -> None:
    missing = ("CAN_BITRATE_500KB", "CAN_BT01_500KB", "VCI_E_WRONG_FLASHFWVERSION", "can_bt0_get_brp")
    assert [name for name in missing if hasattr(vci, name)] == []


@pytest.mark.finding("vendor 10")
def test_a_lin_master_has_a_rate(bal: Any) -> None:
    device = next(iter(v3.VciServer.get_device_manager().get_device_list()))
    with device, device.open_bus_access_layer() as layer, layer.open_socket(2, v3.LinControl) as control:
        assert control.supports_autorate
        init = v3.LinInitLine(v3.LinOperatingModes.MASTER, v3.LinBitrate.AUTO_RATE)
        with pytest.raises(v3.ArgumentException):
            control.init_line(init)
        control.init_line(v3.LinInitLine(v3.LinOperatingModes.SLAVE, v3.LinBitrate.AUTO_RATE))
