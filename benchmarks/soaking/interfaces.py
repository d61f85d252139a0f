"""The eight interfaces by which the soak's programs send and receive."""

from __future__ import annotations

import contextlib
import errno
import select
import socket
import struct
import time
from typing import Any, Protocol

import canwire

RATE = 500_000
LIN_RATE = 19_200
TIMING = canwire.BitTiming.for_bit_rate(RATE, clock_hz=80_000_000)


class Program(Protocol):
    """What is taken for its own is read; `send` says whether the interface took the frame."""

    def send(self, id: int, data: bytes) -> bool: ...
    def read(self) -> int:
        """Frames of other nodes that came since the last time."""

    def account(self) -> dict[str, int]:
        """Of its channel, as far as there is one: ChannelStatus, and `waiting`; of its own queues `waiting`, `lost`."""


def channel_account(channel: Any) -> dict[str, int]:
    """What the hub says of a channel."""
    status = channel.status()
    fields = ("accepted", "lost", "sent", "delivered", "aborted", "refused", "pending")
    told = {name: getattr(status, name) for name in fields}
    ring = channel.reading.ring
    return told | {
        "waiting": ring.fill(), "in channel": ring.fill(), "taken out": ring.taken, "lost in channel": status.lost
    }  # fmt: skip


class Direct:
    """The hub's own handles."""

    def __init__(self, address: str, place: str) -> None:
        self.hub = canwire.connect(address, name="soak canwire")
        board = self.hub.board(place)
        with self.hub.open_control(board.id, 0) as control:
            control.initialise(canwire.LineMode(TIMING))
            control.start()
            self.channel = self.hub.open_channel(board.id, 0)
        self.channel.set_up(canwire.ChannelMode(65_536, 64))
        self.channel.activate()

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.channel.send(canwire.Frame(id, data))
        except canwire.QueueFull:
            return False
        return True

    def read(self) -> int:
        return len(self.channel.receive_many(65_536))

    def account(self) -> dict[str, int]:
        return channel_account(self.channel)


class Vci:
    """Messages of VCI V4 with errors, states and overruns among them, all of which its channel counts."""

    def __init__(self, address: str, place: str) -> None:
        from canwire import vci

        self.vci = vci
        vci.initialize(address)
        with vci.get_device_manager().enum_devices() as devices:
            found = next(info for info in devices if info.hardware_id == place)
        self.device = vci.get_device_manager().open_device(found.vci_object_id)
        bal = self.device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
        self.control = bal.open_socket(0, vci.IID_ICanControl)
        self.control.init_line(
            vci.CanInitLine(vci.CAN_OPMODE_STANDARD, 0, vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)
        )
        self.channel = bal.open_socket(0, vci.IID_ICanSocket).create_channel()
        self.channel.initialize(60_000, 64)
        self.channel.activate()
        self.reader, self.writer = self.channel.get_reader(), self.channel.get_writer()
        self.control.start_line()
        self.others = 0

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.writer.put_data_entry(self.vci.CanMsg(msg_id=id, data=data))
        except self.vci.VciTxQueueFull:
            return False
        return True

    def read(self) -> int:
        frames = 0
        while self.reader.get_fill_count():
            kind = self.reader.get_data_entry().msg_info.type
            frames += kind == self.vci.CAN_MSGTYPE_DATA
            self.others += kind != self.vci.CAN_MSGTYPE_DATA
        return frames

    def account(self) -> dict[str, int]:
        return channel_account(self.channel._lease) | {"others": self.others}


class Acan:
    """A task block with everything, on the SJA1000 of an INduCAN104."""

    def __init__(self, address: str, place: str) -> None:
        from canwire import acan

        self.driver = acan.open(canwire.connect(address, name="soak acan"), place)
        self.driver.configure(acan.HardConfig(rate_kbps=500, ts1=6, ts2=2, sjw=1))
        self.block = acan.TaskBlock([acan.Filter.any()], size=60_000)
        self.driver.register(self.block)
        self.driver.bus_on()

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.driver.send(canwire.Frame(id, data))
        except canwire.QueueFull:
            return False
        return True

    def read(self) -> int:
        return len(self.block.retrieve())

    def account(self) -> dict[str, int]:
        told = channel_account(self.driver._line._channel)
        return told | {"waiting": self.block.occupation, "lost": told["lost"] + self.block.lost}


class Candrv:
    """Events as CANDRV's driver gives them, on the MCP2515 of a PicoCOM."""

    def __init__(self, address: str, place: str) -> None:
        from canwire import candrv

        self.candrv = candrv
        self.handle = candrv.open(place, hub=canwire.connect(address, name="soak candrv"))
        self.handle.baud_rate = RATE
        self.handle.accept_all()
        self.handle.timeouts = candrv.COMMTIMEOUTS(0xFFFF_FFFF, 0, 0, 0, 1)
        self.lost = self.others = 0

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.handle.write_message(id, data)
        except self.candrv.CandrvError as error:
            if error.name in ("ERROR_TIMEOUT", "ERROR_OPERATION_ABORTED"):
                return False
            raise
        return True

    def read(self) -> int:
        frames = 0
        while self.handle.waiting:
            event = self.handle.read_event()
            self.lost += event.lost
            frames += event.event == self.candrv.CANBUS_EVENT_RECEIVED
            self.others += event.event != self.candrv.CANBUS_EVENT_RECEIVED
        return frames

    def account(self) -> dict[str, int]:
        told = channel_account(self.handle._channel._channel)
        return told | {
            "waiting": self.handle.waiting,
            "lost": told["lost"] + self.lost,
            "others": self.others,
        }


class PythonCan:
    """python-can's Bus."""

    def __init__(self, address: str, place: str) -> None:
        import can

        from canwire.python_can import CanwireBus

        self.can = can
        self.bus = CanwireBus(f"{place}:0", hub=address, bitrate=RATE, error_frames=True)
        self.others = 0

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.bus.send(self.can.Message(arbitration_id=id, data=data, is_extended_id=False), timeout=0)
        except self.can.CanError:
            return False
        return True

    def read(self) -> int:
        frames = 0
        while (message := self.bus.recv(0)) is not None:
            frames += not message.is_error_frame
            self.others += message.is_error_frame
        return frames

    def account(self) -> dict[str, int]:
        return channel_account(self.bus._line_channel) | {"others": self.others}


class SocketCan:
    """A raw CAN socket; `canwire run` starts this program, which counts what the socket dropped."""

    _FRAME = struct.Struct("=IB3x8s")
    _RXQ_OVFL = 40

    def __init__(self, address: str, place: str) -> None:
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.setsockopt(socket.SOL_SOCKET, self._RXQ_OVFL, 1)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8 << 20)
        self.socket.bind((place.replace(":", "_"),))
        self.socket.setblocking(False)
        self.lost = self.downs = 0

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.socket.send(self._FRAME.pack(id, len(data), data))
        except OSError:  # EAGAIN, ENOBUFS; ENETDOWN while its line is bus-off
            return False
        return True

    def read(self) -> int:
        frames = 0
        with contextlib.suppress(BlockingIOError):
            while True:
                try:
                    _, ancillary, _, _ = self.socket.recvmsg(16, 64)
                except OSError as error:  # once, when its line was stopped for a moment
                    if error.errno != errno.ENETDOWN:
                        raise
                    self.downs += 1
                    continue
                frames += 1
                for level, kind, value in ancillary:
                    if (level, kind) == (socket.SOL_SOCKET, self._RXQ_OVFL):
                        self.lost = struct.unpack("=I", value)[0]
        return frames

    def account(self) -> dict[str, int]:
        return {"waiting": 0, "lost": self.lost, "downs": self.downs}


class Dongle:
    """An emulated dongle on its pseudo terminal (`place`), spoken to in its ASCII protocol."""

    def __init__(self, address: str, place: str) -> None:
        import serial

        self.port = serial.Serial(place, timeout=0, write_timeout=0)
        self.port.write(b"\r\r\rC\rS6\rO\r")
        time.sleep(0.5)
        self.port.reset_input_buffer()
        self.text = b""
        self.others = self.frames = self.unanswered = self.refused = 0

    def send(self, id: int, data: bytes) -> bool:
        self.port.write(f"t{id:03X}{len(data)}{data.hex().upper()}\r".encode())
        before, ends = self.refused, time.monotonic() + 90
        self.unanswered += 1
        while self.unanswered and time.monotonic() < ends:
            select.select([self.port.fileno()], [], [], 0.1)
            self._take()
        assert not self.unanswered, "the dongle does not answer"
        return self.refused == before

    def read(self) -> int:
        self._take()
        frames, self.frames = self.frames, 0
        return frames

    def account(self) -> dict[str, int]:
        return {"waiting": 0, "lost": 0}

    def _take(self) -> None:
        self.text += self.port.read(1 << 16)
        while self.text:
            if self.text[:1] == b"\a":  # BELL: the ninth to be sent
                self.refused += 1
                self.unanswered -= 1
                self.text = self.text[1:]
                continue
            line, end, rest = self.text.partition(b"\r")
            if not end:
                return
            self.text = rest
            self.frames += line[:1] in b"tTrR" and line != b""
            self.unanswered -= line in (b"z", b"Z", b"")


class Lin:
    """A LIN master with frames of its own and headers that slaves answer; its monitor hears all."""

    def __init__(self, address: str, place: str) -> None:
        self.hub = canwire.connect(address, name="soak lin")
        board = self.hub.board(place)
        self.control = self.hub.open_lin_control(board.id, 2)
        self.control.initialise(canwire.LinMode(True, LIN_RATE))
        self.monitor = self.hub.open_monitor(board.id, 2)
        self.monitor.set_up(canwire.LinMonitorMode(65_536))
        self.monitor.activate()
        self.control.start()

    def send(self, id: int, data: bytes) -> bool:
        try:
            self.control.send(canwire.LinFrame(id & 0x3B, data if id & 1 else None))
        except canwire.Busy:
            return False
        return True

    def read(self) -> int:
        count = 0
        while self.monitor.receive() is not None:
            count += 1
        return count

    def account(self) -> dict[str, int]:
        status = self.monitor.status()
        return {
            "accepted": status.accepted,
            "lost": status.lost,
            "waiting": self.monitor.reading.ring.fill(),
            "in channel": self.monitor.reading.ring.fill(),
            "taken out": self.monitor.reading.ring.taken,
            "lost in channel": status.lost,
        }


KINDS: dict[str, Any] = {
    "canwire": Direct, "vci": Vci, "acan": Acan, "candrv": Candrv, "python-can": PythonCan,
    "socketcan": SocketCan, "dongle": Dongle, "lin": Lin, "network": Direct,
}  # fmt: skip
