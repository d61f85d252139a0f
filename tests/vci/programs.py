"""A program that uses VCI, in tests: what it opens, and its channels' ends."""

from __future__ import annotations

import contextlib
from typing import Any

import canwire
from canwire import vci
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.hub.owner.engine import Engine
from tests.hubs import LONG_S, until

FD_BOARD, CLASSIC_BOARD = "HW000001", "HW000002"
LIN_BOARD = "HW000009"  # for tests that need a second LIN line
LIN_LINE = 2  # of a USB-to-CAN FD


class Virtual:
    """Virtual time, with what only a bench can do: disturb bits."""

    def __init__(self, engine: Engine, program: Program) -> None:
        self.engine = engine
        self.program = program
        self.hub = program.hub
        self.world = engine.world
        bus = self.world.buses["can0"]
        assert isinstance(bus, CanBus)
        self.faults = Faults(bus, 1)


class Port:
    """A channel with both its ends open, or a LIN monitor with its only one."""

    def __init__(self, channel: Any) -> None:
        self.channel = channel
        self.reader = channel.get_reader()
        self.writer: Any = None
        if not isinstance(channel, vci.LinMonitor):
            with contextlib.suppress(vci.VciInvalidState):
                self.writer = channel.get_writer()
        self._event = canwire.Event()
        self.reader.assign_event(self._event)

    def send(self, *messages: Any) -> None:
        for message in messages:
            self.writer.put_data_entry(message)

    def messages(self, count: int, *kinds: int) -> list[Any]:
        """The next `count` messages of these types (none given: data), in order; others on the way are dropped."""
        found: list[Any] = []
        while len(found) < count:
            try:
                message = self.reader.get_data_entry()
            except vci.VciRxQueueEmpty:
                assert self._event.wait(LONG_S), f"{len(found)} of {count} messages came: {found}"
                continue
            if message.msg_info.type in (kinds or (vci.CAN_MSGTYPE_DATA,)):
                found.append(message)
        return found

    def message(self, *kinds: int) -> Any:
        return self.messages(1, *kinds)[0]

    def filled(self) -> list[Any]:
        """Everything, once there is no room for more: over the network a moment after the hub's queue was full."""
        until(lambda: self.reader.get_fill_count() >= self.reader.get_capacity())
        return self.waiting()

    def waiting(self) -> list[Any]:
        """Everything that is there now."""
        found = []
        while self.reader.get_fill_count():
            found.append(self.reader.get_data_entry())
        return found

    def counts(self) -> canwire.ChannelStatus:
        """What the hub counts; VCI does not show it."""
        return self.channel._lease.status()

    def close(self) -> None:
        for end in (self.reader, self.writer, self.channel):
            if end is not None:
                end.__exit__(None, None, None)
        self._event.close()


class Program:
    """What one program opens; all of it is released in the end."""

    def __init__(self, hub: canwire.Hub) -> None:
        self.hub = hub
        self.manager = vci.VciDeviceManager(hub)
        self._opened = contextlib.ExitStack()
        self._bals: dict[str, Any] = {}

    def device(self, board: str = FD_BOARD) -> Any:
        with self.manager.enum_devices() as devices:
            found = next(info for info in devices if info.hardware_id == board)
        return self.keep(self.manager.open_device(found.vci_object_id))

    def bal(self, board: str = FD_BOARD) -> Any:
        if board not in self._bals:
            self._bals[board] = self.keep(
                self.device(board).open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
            )
        return self._bals[board]

    def open(self, iid: Any, line: int = 0, board: str = FD_BOARD) -> Any:
        return self.keep(self.bal(board).open_socket(line, iid))

    def control(self, line: int = 0, board: str = FD_BOARD, iid: Any = vci.IID_ICanControl2) -> Any:
        return self.open(iid, line, board)

    def start(self, line: int = 0, board: str = FD_BOARD, **members: Any) -> Any:
        """A line's control, with the line running at 500 kbit/s, unless members of CANINITLINE2 say otherwise."""
        control = self.control(line, board)
        control.init_line(self.init(**members))
        control.start_line()
        return control

    @staticmethod
    def init(**members: Any) -> Any:
        both = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
        usual: dict[str, Any] = {
            "op_mode": both,
            "btp_sdr": vci.CAN_BTP_500KB,
            "btp_fdr": vci.CAN_BTP_DBR_SL_2000KB,
        }
        return vci.CanInitLine2(**(usual | members))

    def port(
        self,
        line: int = 0,
        board: str = FD_BOARD,
        *,
        rx: int = 200,
        tx: int = 200,
        filter_size: int = 0,
        filter_mode: int = vci.CAN_FILTER_PASS,
        exclusive: bool = False,
        active: bool = True,
    ) -> Port:
        """An ICanChannel2."""
        channel = self.open(vci.IID_ICanSocket2, line, board).create_channel(exclusive)
        channel.initialize(rx, tx, filter_size, filter_mode)
        return self._port(channel, active)

    def old_port(self, line: int = 0, board: str = FD_BOARD, *, rx: int = 200, tx: int = 200) -> Port:
        """An ICanChannel."""
        channel = self.open(vci.IID_ICanSocket, line, board).create_channel(False)
        channel.initialize(rx, tx)
        return self._port(channel, True)

    def monitor(
        self, board: str = FD_BOARD, *, rx: int = 200, exclusive: bool = False, active: bool = True
    ) -> Port:
        """An ILinMonitor."""
        monitor = self.open(vci.IID_ILinSocket, LIN_LINE, board).create_monitor(exclusive)
        monitor.initialize(rx)
        return self._port(monitor, active)

    def lin(self, board: str = FD_BOARD, *, op_mode: int = 0, bitrate: int = 19_200) -> Any:
        """A LIN line's control, with the line running as a slave unless told otherwise."""
        control = self.open(vci.IID_ILinControl, LIN_LINE, board)
        control.init_line(vci.LinInitLine(op_mode=op_mode, bitrate=bitrate))
        control.start_line()
        return control

    def _port(self, channel: Any, active: bool) -> Port:
        port = self._opened.enter_context(contextlib.closing(Port(channel)))
        if active:
            channel.activate()
        return port

    def keep(self, opened: Any) -> Any:
        return self._opened.enter_context(opened)

    def close(self) -> None:
        self._opened.close()
        self.manager.release()
