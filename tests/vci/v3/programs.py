"""A program that uses VCI under the names of V3, in tests."""

from __future__ import annotations

import contextlib
from typing import Any

import canwire
from canwire import vci
from canwire.vci import v3

FD_BOARD = "HW000001"
LONG_MS = 30_000  # after which something that should happen never will
BOTH = v3.CanOperatingModes.STANDARD | v3.CanOperatingModes.EXTENDED


class Port:
    """A channel with its reader and, if it sends, its writer open."""

    def __init__(self, channel: v3.CanChannel, *, sends: bool) -> None:
        self.channel = channel
        self.reader = channel.get_message_reader()
        self.writer: Any = channel.get_message_writer() if sends else None
        self.event = v3.AutoResetEvent()
        self.reader.assign_event(self.event)

    def send(self, *messages: v3.CanMessage) -> None:
        assert self.writer.send_messages(messages) == len(messages)

    def receive(
        self, count: int = 1, kind: v3.CanMsgFrameType = v3.CanMsgFrameType.DATA
    ) -> list[v3.CanMessage]:
        """The next `count` messages of this type; others on the way are dropped."""
        found: list[v3.CanMessage] = []
        while len(found) < count:
            message = self.reader.read_message()
            if message is None:
                assert self.event.wait_one(LONG_MS), f"{len(found)} of {count} messages came: {found}"
            elif message.frame_type == kind:
                found.append(message)
        return found

    def waiting(self, kind: v3.CanMsgFrameType | None = v3.CanMsgFrameType.DATA) -> list[v3.CanMessage]:
        """Everything of this type that is there now; None: of any."""
        return [one for one in self.reader.read_messages(10_000) if kind is None or one.frame_type == kind]

    def close(self) -> None:
        for one in (self.reader, self.writer, self.channel):
            if one is not None:
                one.dispose()
        self.event.close()


class NetProgram:
    """What one program opens, of the board HW000001 unless told otherwise; all of it is disposed in the end."""

    def __init__(self, hub: canwire.Hub) -> None:
        self.hub = hub
        self.manager = v3.VciDeviceManager(vci.VciDeviceManager(hub))
        self._opened = contextlib.ExitStack()

    def device(self, board: str = FD_BOARD) -> v3.VciDevice:
        with self.manager.get_device_list() as devices:
            return self.keep(next(one for one in devices if one.unique_hardware_id == board))

    def bal(self, board: str = FD_BOARD) -> v3.BalObject:
        return self.keep(self.device(board).open_bus_access_layer())

    def open(self, kind: Any, port: int = 0, board: str = FD_BOARD) -> Any:
        with self.bal(board) as bal:
            return self.keep(bal.open_socket(port, kind))

    def control(
        self,
        port: int = 0,
        board: str = FD_BOARD,
        *,
        mode: int = BOTH,
        bitrate: v3.CanBitrate = v3.CanBitrate.CIA_500_KBIT,
    ) -> v3.CanControl:
        """A control unit that is offline."""
        control: v3.CanControl = self.open(v3.CanControl, port, board)
        control.init_line(mode, bitrate)
        return control

    def start(self, port: int = 0, board: str = FD_BOARD, **settings: Any) -> v3.CanControl:
        """A control unit that is online."""
        control = self.control(port, board, **settings)
        control.start_line()
        return control

    def port(
        self, port: int = 0, board: str = FD_BOARD, *, rx: int = 200, tx: int = 200, active: bool = True
    ) -> Port:
        channel: v3.CanChannel = self.open(v3.CanChannel, port, board)
        channel.initialize(rx, tx, False)
        made = self._opened.enter_context(contextlib.closing(Port(channel, sends=tx > 0)))
        if active:
            channel.activate()
        return made

    def status(self, port: int = 0, board: str = FD_BOARD) -> canwire.LineStatus:
        """What the hub counts; VCI does not show all of it."""
        return self.hub.line_status(self.hub.board(board).id, port)

    def keep(self, opened: Any) -> Any:
        return self._opened.enter_context(opened)

    def close(self) -> None:
        self._opened.close()
        self.manager.dispose()
