"""One connection of a socketcand client: its commands, the answers, and its mode."""

from __future__ import annotations

import socket
from collections import deque
from functools import partial
from typing import TYPE_CHECKING

from canwire import BadText
from canwire.socketcan.bcm.message import TX_SEND, Message
from canwire.socketcan.constants import CAN_ERR_FLAG, CAN_MTU, CAN_RTR_FLAG
from canwire.socketcan.daemon.configuring import is_configuration
from canwire.socketcan.daemon.isotp import IsoTp, pdu_of
from canwire.socketcan.daemon.jobs import Jobs
from canwire.socketcan.daemon.statistics import Statistics
from canwire.socketcan.daemon.words import heard, request, sent_frame
from canwire.socketcan.loop import READABLE, WRITABLE
from canwire.socketcan.wire import HEADER_SIZE, row_of, sound

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.wire import Batch

_MOST_UNREAD = 1 << 20  # bytes that wait for a client; frames beyond are lost, and counted
_LONGEST, _LONGEST_PDU = 1 << 14, 1 << 18  # of a command: 257 masks have 6,200, a PDU 132,000
_AT_ONCE = 1 << 16
_MODES = {"rawmode": "raw", "bcmmode": "bcm", "controlmode": "control", "isotpmode": "isotp"}
_SENDS = ("send", "sendrtr", "fdsend")


class Client:
    """`find(name)` opens an interface, `configure` sets one up by a command; both raise OSError.

    `slot` is the unique number of this client. A client that has opened no bus after `greeting_s` seconds is closed.
    """

    def __init__(
        self,
        setting: Setting,
        find: Callable[[str], Port],
        configure: Callable[[list[str]], object],
        slot: int,
        end: socket.socket,
        gone: Callable[[Client], object],
        greeting_s: float,
    ) -> None:
        self.slot = slot
        self.lost = 0
        self._setting = setting
        self._find = find
        self._configure = configure
        self._end = end
        self._gone = gone
        self._mode = "no bus"
        self._port: Port | None = None
        self._input = b""
        self._commands: deque[str] = deque()
        self._output = bytearray()
        self._over = self._writes = self._blocked = False
        self._jobs = Jobs(setting.loop, self._put, self._tell)
        self._statistics = Statistics(setting.loop, self._say)
        self._isotp: IsoTp | None = None
        end.setblocking(False)
        setting.loop.watch(end.fileno(), READABLE, self._ready)
        self._greeting = setting.loop.call_in(
            greeting_s, partial(self.end_with, f"no bus opened within {greeting_s} seconds")
        )
        self._say("< hi >")

    @property
    def silent(self) -> bool:
        """Whether the client has opened no bus yet."""
        return self._port is None

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
        most = _LONGEST if self._mode != "isotp" else _LONGEST_PDU
        if len(self._input) > most or any(len(text) > most for text in whole):
            self.end_with("command too long")
            return
        self._work()

    def _work(self) -> None:
        """Executes the commands that were read while the line has room; only then is more read."""
        while self._commands and not self._over and not self._blocked:
            _, begun, command = self._commands.popleft().partition("<")  # text before it is no command
            try:
                if begun:
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
        except BlockingIOError:  # the rest when there is room: `_watch_again` sees to that
            pass
        except OSError:
            self.close()
            return
        self._watch_again()

    def _watch_again(self) -> None:
        if not self._over:
            events = (0 if self._blocked else READABLE) | (WRITABLE if self._output else 0)
            self._setting.loop.watch(self._end.fileno(), events, self._ready)

    def end_with(self, why: str) -> None:
        """Close the connection with a reason."""
        self._say(f"< error {why} >")
        self.close()

    def close(self) -> None:
        """Close the connection; a second call has no effect."""
        if self._over:
            return
        self._over = True
        self._greeting.cancel()
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
            self._statistics.ask(words)
        elif self._mode == "isotp":
            self._exchange(self._port, words)
        elif words[0] in _SENDS:
            self._send(self._port, sent_frame(words))
        elif self._mode == "bcm":
            self._manage(self._port, request(words))
        else:
            raise BadText("unknown command")

    def _open(self, words: list[str]) -> None:
        try:
            if is_configuration(words):
                self._configure(words)
                self._say("< ok >")
                return
            if len(words) != 2 or words[0] != "open":
                raise BadText("open a bus first, as in: open can0")
            self._port = self._find(words[1])
        except OSError as error:
            opens = words[0] == "open"
            self.end_with(
                f"could not open bus {words[1][:16]}"
                if opens
                else f"configuring interface {words[0][:16]}: {error.strerror or error}"
            )
            return
        self._greeting.cancel()
        self._port.listeners.append(self)
        self._mode = "bcm"
        self._say("< ok >")
        self._port.tell_if_down(self)

    def _leave_mode(self) -> None:
        self._jobs.stop()
        self._statistics.stop()
        if self._isotp is not None:
            self._isotp.stop()
            self._isotp = None

    def _exchange(self, port: Port, words: list[str]) -> None:
        """A command of the ISO-TP mode."""
        if words[0] == "isotpconf" and self._isotp is None:
            self._isotp = IsoTp(self._setting.loop, words, partial(self._put_surely, port), self._tell)
        elif words[0] != "sendpdu":
            raise BadText("unknown command")
        elif self._isotp is None:
            raise BadText("set the channel up first, as in: isotpconf 123 321 0 0 0")
        else:
            self._isotp.send(pdu_of(words))

    # sending

    def _send(self, port: Port, frame: bytes) -> None:
        row = row_of(frame, port.interface.index)
        if not sound(row).all():
            raise BadText("this frame cannot be sent")
        if port.lost:
            self.end_with("the bus is gone")
        elif port.room():
            self._statistics.send(frame[4])
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
        if message.opcode == TX_SEND:
            self._send(port, message.frames[0])
        else:
            self._jobs.manage(message)

    def _put(self, frame: bytes) -> None:
        """Send a frame of a job; it may be dropped, since the next one follows."""
        port = self._port
        if port is not None and port.room():
            self._put_surely(port, frame)
        else:
            self.lost += 1

    def _put_surely(self, port: Port, frame: bytes) -> None:
        """Send a frame as soon as there is room."""
        if self._over or port.lost:
            return
        if port.room():
            self._statistics.send(frame[4])
            port.send(self.slot, row_of(frame, port.interface.index))
        else:
            port.when_room(partial(self._put_surely, port, frame))

    # hearing

    def take(self, batch: Batch) -> None:
        """See Listener: frames of the interface have arrived."""
        if self._mode == "raw" or self._jobs.watchings or self._mode == "control" or self._isotp is not None:
            for row, owner in zip(batch.rows, batch.owners, strict=True):
                frame = row.tobytes()[HEADER_SIZE : HEADER_SIZE + int(row["length"])]
                self._hear(frame, int(row["stamp_ns"]), int(owner) == self.slot)

    def _hear(self, frame: bytes, stamp_ns: int, own: bool) -> None:
        can_id = int.from_bytes(frame[:4], "little")
        if not can_id & CAN_ERR_FLAG:
            self._statistics.receive(frame[4])
        if self._mode == "raw" and not own:
            self._tell(heard(frame, stamp_ns, apart=False))
        elif self._mode == "bcm" and len(frame) == CAN_MTU and can_id in self._jobs.watchings:
            self._jobs.watchings[can_id].take(frame, stamp_ns)
        elif self._isotp is not None and len(frame) == CAN_MTU and not can_id & (CAN_ERR_FLAG | CAN_RTR_FLAG):
            self._isotp.take(can_id, frame[8 : 8 + frame[4]], stamp_ns, own)

    def _tell(self, text: str) -> None:
        if len(self._output) > _MOST_UNREAD:
            self.lost += 1
        else:
            self._say(text)

    def congested(self) -> bool:
        """See Listener: a hub in fast time waits for a client that reads slowly."""
        return len(self._output) > _MOST_UNREAD // 2

    def interface_lost(self, interface: Interface, error: int) -> None:
        """See Listener: the line of the interface was stopped or is gone."""
        self.end_with(f"{interface.name} is down")
