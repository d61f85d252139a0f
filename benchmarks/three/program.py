"""The programs of bench_of_three.py, each of which keeps an account: `python program.py KIND ADDRESS PLACE NUMBER`.

`source` sends numbered frames 0x100, `commander` commands with the time at which they are given, 0x200 and up; `looker`
sees when commands come, and it and the others read everything. The word `account` on its input is answered by a line of
JSON, `stop` ends sending. It ends with its input, or with a line of JSON and status 3 when its hub is lost.
"""

from __future__ import annotations

import json
import select
import socket
import struct
import sys
import time
from pathlib import Path
from typing import Any, Protocol

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent.parent))

from soaking.interfaces import RATE, TIMING, Candrv, PythonCan, SocketCan, Vci, channel_account

import canwire

NUMBERED, COMMANDS = 0x100, 0x200
_PAYLOAD = struct.Struct("<HI")  # which life of the source, and the frame's number in it
_TIME = struct.Struct("<Q")
_PAUSE_S = 0.02
_RING = 256  # frames: what a cut of some seconds overflows
_LOST = 3
Read = list[tuple[int, bytes]]


class Reader(Protocol):
    """What comes by one interface, and the account of its channel."""

    def frames(self) -> Read: ...
    def account(self) -> dict[str, int]: ...


class Direct:
    """The hub's own handles."""

    def __init__(self, address: str, place: str) -> None:
        self.hub = canwire.connect(address, name=f"three {place}")
        board = self.hub.board(place)
        self.channel = self.hub.open_channel(board.id, 0)
        with self.hub.open_control(board.id, 0) as control:
            control.initialise(canwire.LineMode(TIMING))
            control.start()
        self.channel.set_up(canwire.ChannelMode(_RING, 256))
        self.channel.activate()

    def frames(self) -> Read:
        return [(frame.id, frame.data) for frame in self.channel.receive_many(1 << 16)]

    def account(self) -> dict[str, int]:
        return channel_account(self.channel)


class VciFrames(Vci):
    def frames(self) -> Read:
        found = []
        while self.reader.get_fill_count():
            message = self.reader.get_data_entry()
            if message.msg_info.type == self.vci.CAN_MSGTYPE_DATA:
                found.append((message.msg_id, bytes(message.data)))
            else:
                self.others += 1
        return found


class CandrvFrames(Candrv):
    def frames(self) -> Read:
        found = []
        while (event := self._next()) is not None:
            self.lost += event.lost
            if event.event == self.candrv.CANBUS_EVENT_RECEIVED:
                found.append((event.identifier, bytes(event.data)))
            else:
                self.others += 1
        return found

    def _next(self) -> Any:
        """`waiting` would not say that the hub is lost."""
        try:
            return self.handle.read_event()
        except self.candrv.CandrvError as error:
            if error.name == "ERROR_TIMEOUT":
                return None
            raise


class PythonCanFrames(PythonCan):
    def frames(self) -> Read:
        found = []
        while (message := self.bus.recv(0)) is not None:
            if message.is_error_frame:
                self.others += 1
            else:
                found.append((message.arbitration_id, bytes(message.data)))
        return found


class SocketCanFrames(SocketCan):
    def frames(self) -> Read:
        found = []
        while select.select([self.socket], [], [], 0)[0]:
            data, ancillary, _, _ = self.socket.recvmsg(16, 64)
            for level, kind, value in ancillary:
                if (level, kind) == (socket.SOL_SOCKET, self._RXQ_OVFL):
                    self.lost = struct.unpack("=I", value)[0]
            id, length, payload = self._FRAME.unpack(data)
            found.append((id, payload[:length]))
        return found


KINDS: dict[str, Any] = {
    "source": Direct,
    "looker": Direct,
    "commander": Direct,
    "direct": Direct,
    "vci": VciFrames,
    "candrv": CandrvFrames,
    "python-can": PythonCanFrames,
    "socketcan": SocketCanFrames,
}


def command(kind: str, address: str, place: str, number: int) -> list[str]:
    """What starts one."""
    own = [sys.executable, str(Path(__file__).resolve()), kind, address, place, str(number)]
    run = [sys.executable, "-m", "canwire", "run", "--hub", address, "--bit-rate", str(RATE)]
    return [*run, *own] if kind == "socketcan" else own


class Numbers:
    """The numbered frames that a program has seen, in the order in which it should."""

    def __init__(self) -> None:
        self.life = self.first = self.last = -1
        self.seen = self.wrong = 0

    def take(self, life: int, number: int) -> None:
        if life != self.life:  # the source was started anew
            self.wrong += life < self.life
            self.life, self.first, self.last = life, number, number - 1
            self.before = self.seen
        self.wrong += number <= self.last
        self.seen += 1
        self.last = max(self.last, number)

    def account(self) -> dict[str, int]:
        gaps = 0 if self.life < 0 else self.last - self.first + 1 - (self.seen - self.before)
        return {"life": self.life, "last": self.last, "seen": self.seen, "gaps": gaps, "wrong": self.wrong}


class Program:
    """Sends and reads, and does what its input says."""

    def __init__(self, kind: str, reader: Reader, number: int) -> None:
        self.kind, self.reader, self.number = kind, reader, number
        self.numbers = Numbers()
        self.sends = kind in ("source", "commander")
        self.given = self.read = self.latest_ms = 0
        self.commands: dict[int, int] = {}
        self.next_s = time.monotonic()
        self._looked_ns = time.monotonic_ns()

    def run(self) -> None:
        while True:
            ready, _, _ = select.select([0], [], [], _PAUSE_S)
            if ready:
                word = sys.stdin.buffer.raw.readline().decode().strip()  # type: ignore[attr-defined]
                if not word:
                    return
                self.sends = self.sends and word != "stop"
                if word == "account":
                    print(json.dumps(self.account()), flush=True)
            self.take()
            if self.sends:
                self.send()

    def take(self) -> None:
        """Read everything. A command came after the look before this one: how late this program is does not count."""
        before_ns, self._looked_ns = self._looked_ns, time.monotonic_ns()
        for id, data in self.reader.frames():
            self.read += 1
            if id == NUMBERED:
                self.numbers.take(*_PAYLOAD.unpack(data[: _PAYLOAD.size]))
            elif id >= COMMANDS and self.kind == "looker":
                late_ms = (before_ns - _TIME.unpack(data)[0]) // 1_000_000
                self.latest_ms = max(self.latest_ms, late_ms)
                self.commands[id] = self.commands.get(id, 0) + 1

    def send(self) -> None:
        every_s = 0.01 if self.kind == "source" else 0.05
        while time.monotonic() >= self.next_s:
            self.next_s += every_s
            if self.kind == "source":
                frame = canwire.Frame(NUMBERED, _PAYLOAD.pack(self.number, self.given))
            else:
                frame = canwire.Frame(COMMANDS + self.number % 256, _TIME.pack(time.monotonic_ns()))
            try:
                self.reader.channel.send(frame)  # type: ignore[attr-defined]
            except canwire.QueueFull:
                continue
            self.given += 1

    def account(self) -> dict[str, object]:
        self.take()
        own = {"read": self.read, "given": self.given, "latest_ms": self.latest_ms, "commands": self.commands}
        return {**self.numbers.account(), **own, **self.reader.account()}


def main(kind: str, address: str, place: str, number: str) -> int:
    program = None
    try:
        program = Program(kind, KINDS[kind](address, place), int(number))
        print("at it", flush=True)
        program.run()
    except (canwire.CanwireError, OSError, RuntimeError) as error:
        if program is None:
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
            return _LOST
        told = {**program.numbers.account(), "given": program.given, "latest_ms": program.latest_ms}
        print(json.dumps({"over": f"{type(error).__name__}: {error}", **told}), flush=True)
        return _LOST
    except Exception as error:  # python-can's and CANDRV's own
        print(json.dumps({"over": f"{type(error).__name__}: {error}"}), flush=True)
        return _LOST
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
