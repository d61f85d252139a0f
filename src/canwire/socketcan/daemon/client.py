"""One connection of a socketcand client: what it asks for, what it is told, in which mode."""

from __future__ import annotations

import socket
from collections import deque
from typing import TYPE_CHECKING

from canwire import BadText
from canwire.socketcan.bcm.message import RX_CHANGED, RX_DELETE, RX_SETUP, TX_DELETE, TX_SEND, Message
from canwire.socketcan.bcm.sending import Sending
from canwire.socketcan.bcm.watching import Watching
from canwire.socketcan.constants import CAN_ERR_FLAG, CAN_MTU
from canwire.socketcan.daemon.words import heard, request, sent_frame
from canwire.socketcan.loop import READABLE, WRITABLE, Timer
from canwire.socketcan.wire import HEADER_SIZE, row_of, sound

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.wire import Batch

_MOST_UNREAD = 1 << 20  # bytes that wait for a client; frames beyond are lost, and counted
_LONGEST = 1 << 14  # of a command: a muxfilter with 257 masks has 6,200 characters
_AT_ONCE = 1 << 16
_MODES = {"rawmode": "raw", "bcmmode": "bcm", "controlmode": "control"}
_SENDS = ("send", "sendrtr", "fdsend")
_LONGEST_INTERVAL_MS = 1 << 31


class Client:
    """`find(name)` opens an interface, or raises OSError; `slot` is this client's number among all."""

    def __init__(
        self,
        setting: Setting,
        find: Callable[[str], Port],
        slot: int,
        end: socket.socket,
        gone: Callable[[Client], object],
    ) -> None:
        self.slot = slot
        self.lost = 0
        self._setting = setting
        self._find = find
        self._end = end
        self._gone = gone
        self._mode = "no bus"
        self._port: Port | None = None
        self._input = b""
        self._commands: deque[str] = deque()
        self._output = bytearray()
        self._over = self._writes = self._blocked = False
        self._sendings: dict[int, Sending] = {}
        self._watchings: dict[int, Watching] = {}
        self._statistics: Timer | None = None
        self._received = [0, 0]  # frames, bytes
        self._sent = [0, 0]
        end.setblocking(False)
        setting.loop.watch(end.fileno(), READABLE, self._ready)
        self._say("< hi >")

    # the connection

    def _ready(self, events: int) -> None:
        if events & WRITABLE:
            self._flush()
        if not self._over and events & ~WRITABLE:
            self._read()

    def _read(self) -> None:
        try:
            chunk = self._end.recv(_AT_ONCE)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        if not chunk:
            self.close()
            return
        self._input += chunk
        *whole, self._input = self._input.split(b">")
        self._commands += [text.decode("ascii", "replace") for text in whole]
        if len(self._input) > _LONGEST or any(len(text) > _LONGEST for text in whole):
            self._end_with("command too long")
            return
        self._work()

    def _work(self) -> None:
        """What has been read, as far as the line has room for it; only then is more read."""
        while self._commands and not self._over and not self._blocked:
            _, begun, command = self._commands.popleft().partition("<")  # what stands before it is no command
            try:
                if not begun:
                    raise BadText("a command begins with <")
                self._do(command.split())
            except BadText as error:
                self._say(f"< error {error} >")
        self._watch_again()

    def _say(self, text: str) -> None:
        if self._over:
            return
        self._output += text.encode("ascii", "replace")
        self._flush()

    def _flush(self) -> None:
        try:
            while self._output:
                del self._output[: self._end.send(self._output)]
        except BlockingIOError:
            pass  # the rest when there is room: `_watch_again` sees to that
        except OSError:
            self.close()
            return
        self._watch_again()

    def _watch_again(self) -> None:
        if not self._over:
            events = (0 if self._blocked else READABLE) | (WRITABLE if self._output else 0)
            self._setting.loop.watch(self._end.fileno(), events, self._ready)

    def _end_with(self, why: str) -> None:
        self._say(f"< error {why} >")
        self.close()

    def close(self) -> None:
        """A second time does nothing."""
        if self._over:
            return
        self._over = True
        self._leave_mode()
        if self._port is not None:
            self._port.leave(self)
        self._setting.loop.forget(self._end.fileno())
        self._end.close()
        self._gone(self)

    # commands

    def _do(self, words: list[str]) -> None:
        if not words:
            raise BadText("empty command")
        if self._port is None:
            self._open(words)
        elif words == ["echo"]:
            self._say("< echo >")
        elif len(words) == 1 and words[0] in _MODES:
            self._leave_mode()
            self._mode = _MODES[words[0]]
            self._say("< ok >")
        elif self._mode == "control" and words[0] == "statistics":
            self._count_for(words)
        elif words[0] in _SENDS:
            self._send(self._port, sent_frame(words))
        elif self._mode == "bcm":
            self._manage(self._port, request(words))
        else:
            raise BadText("unknown command")

    def _open(self, words: list[str]) -> None:
        if len(words) != 2 or words[0] != "open":
            raise BadText("open a bus first, as in: open can0")
        try:
            self._port = self._find(words[1])
        except OSError:
            self._end_with(f"could not open bus {words[1][:16]}")
            return
        self._port.listeners.append(self)
        self._mode = "bcm"
        self._say("< ok >")
        self._port.tell_if_down(self)

    def _leave_mode(self) -> None:
        operations: list[Sending | Watching] = [*self._sendings.values(), *self._watchings.values()]
        for operation in operations:
            operation.stop()
        self._sendings.clear()
        self._watchings.clear()
        if self._statistics is not None:
            self._statistics.cancel()
            self._statistics = None

    def _count_for(self, words: list[str]) -> None:
        if len(words) != 2 or not words[1].isdecimal() or int(words[1]) > _LONGEST_INTERVAL_MS:
            raise BadText("statistics: an interval in milliseconds")
        if self._statistics is not None:
            self._statistics.cancel()
            self._statistics = None
        interval_s = int(words[1]) / 1000
        if interval_s:
            self._statistics = self._setting.loop.call_in(interval_s, lambda: self._tell_counts(interval_s))

    def _tell_counts(self, interval_s: float) -> None:
        self._say(f"< stat {self._received[1]} {self._received[0]} {self._sent[1]} {self._sent[0]} >")
        if not self._over:
            self._statistics = self._setting.loop.call_in(interval_s, lambda: self._tell_counts(interval_s))

    # sending

    def _send(self, port: Port, frame: bytes) -> None:
        row = row_of(frame, port.interface.index)
        if not sound(row).all():
            raise BadText("no such frame can be sent")
        if port.lost:
            self._end_with("the bus is gone")
        elif port.room():
            self._sent[0] += 1
            self._sent[1] += frame[4]
            port.send(self.slot, row)
        else:
            self._blocked = True  # nothing more is read from this client until this one has gone
            port.when_room(lambda: self._go_on(port, frame))

    def _go_on(self, port: Port, frame: bytes) -> None:
        if not self._over:
            self._blocked = False
            self._send(port, frame)
            self._work()

    def _manage(self, port: Port, message: Message) -> None:
        can_id = message.can_id
        if message.opcode == TX_SEND:
            self._send(port, message.frames[0])
        elif message.opcode == TX_DELETE and can_id in self._sendings:
            self._sendings.pop(can_id).stop()
        elif message.opcode == RX_DELETE and can_id in self._watchings:
            self._watchings.pop(can_id).stop()
        elif message.opcode in (TX_DELETE, RX_DELETE):
            raise BadText("there is no such job")
        elif message.opcode == RX_SETUP:
            if can_id in self._watchings:
                self._watchings.pop(can_id).stop()
            self._watchings[can_id] = Watching(self._setting.loop, lambda _: None, self._changed, message)
        elif can_id in self._sendings:
            self._sendings[can_id].change(message)
        elif not message.flags:
            raise BadText("there is no such job")
        else:
            self._sendings[can_id] = Sending(
                self._setting.loop, lambda frame: self._put(port, frame), lambda _: None, message
            )

    def _put(self, port: Port, frame: bytes) -> None:
        """One of a job's frames: the next one comes anyway."""
        if port.room():
            self._sent[0] += 1
            self._sent[1] += frame[4]
            port.send(self.slot, row_of(frame, port.interface.index))
        else:
            self.lost += 1

    # hearing

    def take(self, batch: Batch) -> None:
        """Frames of the interface: Listener's."""
        if self._mode == "raw" or self._watchings or self._mode == "control":
            for row, owner in zip(batch.rows, batch.owners, strict=True):
                frame = row.tobytes()[HEADER_SIZE : HEADER_SIZE + int(row["length"])]
                self._hear(frame, int(row["stamp_ns"]), int(owner) == self.slot)

    def _hear(self, frame: bytes, stamp_ns: int, own: bool) -> None:
        can_id = int.from_bytes(frame[:4], "little")
        if not can_id & CAN_ERR_FLAG:
            self._received[0] += 1
            self._received[1] += frame[4]
        if self._mode == "raw" and not own:
            self._tell(heard(frame, stamp_ns, apart=False))
        elif self._mode == "bcm" and len(frame) == CAN_MTU and can_id in self._watchings:
            self._watchings[can_id].take(frame, stamp_ns)

    def _changed(self, message: Message, stamp_ns: int) -> None:
        if message.opcode == RX_CHANGED:
            self._tell(heard(message.frames[0], stamp_ns, apart=True))

    def _tell(self, text: str) -> None:
        if len(self._output) > _MOST_UNREAD:
            self.lost += 1
        else:
            self._say(text)

    def congested(self) -> bool:
        """A hub in fast time waits for whoever reads slowly: Listener's."""
        return len(self._output) > _MOST_UNREAD // 2

    def interface_lost(self, interface: Interface, error: int) -> None:
        """Its line was stopped or is gone: Listener's."""
        self._end_with(f"{interface.name} is down")
