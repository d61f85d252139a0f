"""A program of the shape of the vendor's public console samples, line by line: CAN FD and classic."""

from __future__ import annotations

from typing import Any

import pytest

import canwire
from canwire.vci.net4 import (
    AutoResetEvent,
    CanBitrate,
    CanBitrate2,
    CanCyclicTXIncMode,
    CanCyclicTXStatus,
    CanExtendedOperatingModes,
    CanFeatures,
    CanFilterModes,
    CanMsgError,
    CanMsgFrameType,
    CanMsgInfoValue,
    CanOperatingModes,
    ICanChannel,
    ICanChannel2,
    ICanControl,
    ICanControl2,
    ICanMessage,
    ICanMessage2,
    ICanScheduler,
    ICanScheduler2,
    IVciDevice,
    VciServer,
)
from tests.vci.net4.programs import Net4

ERRORS = {
    CanMsgError.STUFF: "stuff error",
    CanMsgError.FORM: "form error",
    CanMsgError.ACKNOWLEDGE: "acknowledgment error",
    CanMsgError.BIT: "bit error",
    CanMsgError.FDB: "fast data bit error",
    CanMsgError.CRC: "CRC error",
    CanMsgError.DLC: "data length error",
    CanMsgError.OTHER: "other error",
}


def select_device() -> IVciDevice:
    device_manager = VciServer.instance().device_manager
    device_list = device_manager.get_device_list()
    device_enum = device_list.get_enumerator()
    device_enum.move_next()
    device = device_enum.current
    info = device.equipment[0]
    assert info.bus_type == 1
    for one in (device_manager, device_list, device_enum):
        one.dispose()
    return device


class ConsoleSample:
    """`long`: with the interfaces for CAN FD."""

    def __init__(self, device: IVciDevice, can_no: int, long: bool) -> None:
        self.long = long
        bal = device.open_bus_access_layer()
        try:
            self.open(bal, can_no)
        finally:
            bal.dispose()

    def open(self, bal: Any, can_no: int) -> None:
        self.chn = bal.open_socket(can_no, ICanChannel2 if self.long else ICanChannel)
        self.sched: Any = None
        if CanFeatures.SCHEDULER in self.chn.features:
            self.sched = bal.open_socket(can_no, ICanScheduler2 if self.long else ICanScheduler)
            self.sched.reset()
            self.sched.resume()
        if self.long:
            self.chn.initialize(1024, 128, 100, CanFilterModes.PASS, False)
        else:
            self.chn.initialize(1024, 128, False)
        self.reader = self.chn.get_message_reader()
        self.reader.threshold = 1
        self.rx_event = AutoResetEvent(False)
        self.reader.assign_event(self.rx_event)
        self.writer = self.chn.get_message_writer()
        self.writer.threshold = 1
        self.chn.activate()
        self.ctl = bal.open_socket(can_no, ICanControl2 if self.long else ICanControl)
        mode = CanOperatingModes.STANDARD | CanOperatingModes.EXTENDED | CanOperatingModes.ERR_FRAME
        if self.long:
            self.ctl.init_line(
                mode,
                CanExtendedOperatingModes.EXTENDED_DATA_LENGTH | CanExtendedOperatingModes.FAST_DATA_RATE,
                CanFilterModes.PASS,
                2048,
                CanFilterModes.PASS,
                2048,
                CanBitrate2.CANFD_500_KBIT,
                CanBitrate2.CANFD_2000_KBIT,
            )
        else:
            self.ctl.init_line(mode, CanBitrate.CIA_500_KBIT)
        assert "500" in str(self.ctl.line_status.bitrate)
        self.ctl.start_line()

    def cyclic(self) -> Any:
        message = self.sched.add_message()
        message.auto_increment_mode = CanCyclicTXIncMode.NO_INC
        message.identifier = 200
        message.cycle_ticks = 100
        message.data_length = 32 if self.long else 8
        if self.long:
            message.extended_data_length = True
            message.fast_data_rate = True
        for i in range(message.data_length):
            message[i] = i
        return message

    def transmit_data(self) -> None:
        factory = VciServer.instance().msg_factory
        message: Any = factory.create_msg(ICanMessage2) if self.long else factory.create_msg(ICanMessage)
        message.time_stamp = 0
        message.identifier = 0x100
        message.frame_type = CanMsgFrameType.DATA
        message.data_length = 64 if self.long else 8
        message.self_reception_request = True
        if self.long:
            message.fast_data_rate = True
            message.extended_data_length = True
        for i in range(message.data_length):
            message[i] = i
        self.writer.send_message(message)

    def printed(self, message: Any) -> str:
        if message.frame_type == CanMsgFrameType.DATA:
            if message.remote_transmission_request:
                return f"ID: {message.identifier:3X}  DLC: {message.data_length}  Remote Frame"
            data = "".join(f" {message[index]:02X}" for index in range(message.data_length))
            return f"ID: {message.identifier:3X}  DLC: {message.data_length}  Data:{data}"
        if message.frame_type == CanMsgFrameType.INFO:
            return f"CAN {CanMsgInfoValue(message[0]).name}"
        if message.frame_type == CanMsgFrameType.ERROR:
            return ERRORS[CanMsgError(message[0])]
        return ""

    def receive(self, wanted: str) -> list[str]:
        """The thread that receives, until it prints what is wanted."""
        shown: list[str] = []
        for _ in range(300):
            if self.rx_event.wait_one(100, False):
                while message := self.reader.read_message():
                    shown.append(self.printed(message))
                if wanted in shown:
                    break
        return shown

    def finalize(self) -> None:
        for one in (self.reader, self.writer, self.sched, self.chn, self.ctl):
            if one is not None:
                one.dispose()


def hexed(count: int) -> str:
    return "".join(f" {k:02X}" for k in range(count))


@pytest.mark.finding("dialects 9")
@pytest.mark.parametrize(("long", "cyclic", "single"), [(True, 32, 64), (False, 8, 8)], ids=["CAN FD", "CAN"])
def test_the_console_samples(hub: canwire.Hub, net4: Net4, long: bool, cyclic: int, single: int) -> None:
    net4.start(1, fast=long)
    partner = net4.port(1)
    device = select_device()
    sample = ConsoleSample(device, 0, long)
    sample.transmit_data()
    printed = f"ID: 100  DLC: {single}  Data:{hexed(single)}"
    shown = sample.receive(printed)
    assert (shown[0], shown[-1]) == ("CAN START", printed)
    message = sample.cyclic()
    for _ in range(2):  # the key that starts and stops
        if message.status != CanCyclicTXStatus.BUSY:
            message.start(0)
            partner.receive(3)
        else:
            message.stop()
    assert message.status == CanCyclicTXStatus.DONE
    sample.ctl.stop_line()
    assert sample.receive("CAN STOP")[-2:] == ["CAN STOP", ""]
    sample.finalize()
    device.dispose()
    heard = [one for one in partner.reader.read_messages() if one.identifier == 200]
    assert all(one.data_length == cyclic for one in heard)


@pytest.mark.finding("dialects 9")
def test_a_frame_that_nobody_acknowledges_is_printed(virtual4: Net4) -> None:
    device = select_device()
    sample = ConsoleSample(device, 0, True)
    sample.transmit_data()
    assert "acknowledgment error" in sample.receive("acknowledgment error")
    sample.finalize()
    device.dispose()
