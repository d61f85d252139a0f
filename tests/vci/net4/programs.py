"""A program that uses VCI under the names of Ixxat.Vci4, in tests."""

from __future__ import annotations

import contextlib
from typing import Any

import canwire
from canwire.vci import net4

FD_BOARD, CLASSIC_BOARD = "HW000001", "HW000002"
LONG_MS = 30_000  # after which something that should happen never will
FD = net4.CanExtendedOperatingModes.EXTENDED_DATA_LENGTH | net4.CanExtendedOperatingModes.FAST_DATA_RATE
BOTH = net4.CanOperatingModes.STANDARD | net4.CanOperatingModes.EXTENDED


class Port:
    """A channel with both its ends open."""

    def __init__(self, channel: Any) -> None:
        self.channel = channel
        self.reader = channel.get_message_reader()
        self.writer = channel.get_message_writer()
        self.event = net4.AutoResetEvent()
        self.reader.assign_event(self.event)

    def receive(self, count: int = 1, kind: net4.CanMsgFrameType = net4.CanMsgFrameType.DATA) -> list[Any]:
        """The next `count` messages of this type; others on the way are dropped."""
        found: list[Any] = []
        while len(found) < count:
            message = self.reader.read_message()
            if message is None:
                assert self.event.wait_one(LONG_MS, False), f"{len(found)} of {count} messages came: {found}"
            elif message.frame_type == kind:
                found.append(message)
        return found

    def close(self) -> None:
        for one in (self.reader, self.writer, self.channel):
            one.dispose()
        self.event.close()


class Net4:
    """What one program opens; all of it is disposed in the end."""

    def __init__(self, hub: canwire.Hub) -> None:
        self.hub = hub
        self.server = net4.VciServer.instance()
        self._opened = contextlib.ExitStack()

    def open(self, kind: Any, port: int = 0, board: str = FD_BOARD) -> Any:
        with self.server.device_manager as manager, manager.get_device_list() as devices:
            device = next(one for one in devices if one.unique_hardware_id == board)
        with device, device.open_bus_access_layer() as bal:
            return self._opened.enter_context(bal.open_socket(port, kind))

    def start(
        self, port: int = 0, board: str = FD_BOARD, *, fast: bool = True, started: bool = True
    ) -> net4.CanControl2:
        """A line at 500 kbit/s, and 2 Mbit/s where it is `fast`."""
        control: net4.CanControl2 = self.open(net4.ICanControl2, port, board)
        control.init_line(
            BOTH,
            FD if fast else 0,
            net4.CanFilterModes.PASS,
            2048,
            net4.CanFilterModes.PASS,
            2048,
            net4.CanBitrate2.CANFD_500_KBIT if fast else net4.CanBitrate2.CIA_500_KBIT,
            net4.CanBitrate2.CANFD_2000_KBIT if fast else net4.CanBitrate2.EMPTY,
        )
        if started:
            control.start_line()
        return control

    def port(self, port: int = 0, board: str = FD_BOARD, *, classic: bool = False) -> Port:
        """An active channel: ICanChannel2, or ICanChannel where it is `classic`."""
        channel = self.open(net4.ICanChannel if classic else net4.ICanChannel2, port, board)
        sizes = (200, 200) if classic else (200, 200, 100, net4.CanFilterModes.PASS)
        channel.initialize(*sizes, False)
        made = self._opened.enter_context(contextlib.closing(Port(channel)))
        channel.activate()
        return made

    def message(self, kind: Any, identifier: int, data: bytes = b"", **properties: Any) -> Any:
        """A message of the factory's."""
        made = self.server.msg_factory.create_msg(kind)
        fill(made, identifier, data, **properties)
        return made

    def close(self) -> None:
        self._opened.close()


def fill(message: Any, identifier: int, data: bytes = b"", **properties: Any) -> None:
    message.identifier, message.data_length = identifier, len(data)
    for index, byte in enumerate(data):
        message[index] = byte
    for name, value in properties.items():
        setattr(message, name, value)
