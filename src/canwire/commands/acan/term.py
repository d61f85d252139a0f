"""CANTERM without its screen: characters to messages and back, echo, loop, the two bursts.

Source: INduCAN104 manual, "CANTERM".
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from canwire import Frame, QueueFull, acan
from canwire.commands.acan.conditions import WATCHED, news
from canwire.commands.acan.machines import identifier

if TYPE_CHECKING:
    from canwire.acan import Driver, TaskBlock

CTRL_C, CTRL_T, CTRL_U = b"\x03", b"\x14", b"\x15"
SEQUENCE = b"0123456789ABCDEF"
_BOXES = 5
_INSIDE = (r"\     /", r" \   / ", r"  \ /  ", "   |   ", "   |   ", r"  / \  ", r" /   \ ", "/     \\")
# 8 rows of 41 characters and CR LF: 344. The scan of the manual has lost the middle; first and last row are its own
PATTERN = "".join("|" + "|".join([inside] * _BOXES) + "|\r\n" for inside in _INSIDE).encode()
_BURSTS = {CTRL_U: SEQUENCE, CTRL_T: PATTERN}
_KEYS = re.compile(b"([\x14\x15])")

_LARGEST = 8  # bytes of a message
_PRIORITY = 1  # 0 would bring every message back to this machine
_PATIENCE_S = 1.0  # for room in the driver's queue
_MESSAGES = 256  # that wait for this program: several whole patterns


class Terminal:
    """One end of a conversation over the bus.

    `local` is 1 to 7, `remote` 0 to 7. `woken` is called, on the driver's thread, when `received` has something.
    """

    def __init__(
        self,
        driver: Driver,
        local: int,
        remote: int,
        *,
        echo: bool = False,
        loop: bool = False,
        woken: Callable[[], None] = lambda: None,
    ) -> None:
        self.driver = driver
        self.local, self.remote = local, remote
        self.echo, self.loop = echo, loop
        self.complaints: list[str] = []  # the screen that shows them removes them
        self._woken = woken
        self._block: TaskBlock | None = None

    def open(self) -> None:
        """Receive from now on what is for this machine and what is for all."""
        block = acan.TaskBlock(
            [acan.Filter.one(identifier(self.local)), acan.Filter.one(identifier(acan.BROADCAST))],
            conditions=WATCHED,
            size=_MESSAGES,
            notify=lambda block: self._woken(),
        )
        self.driver.register(block)
        self._block = block

    def close(self) -> None:
        """Receive no more; closed already, it stays so."""
        block, self._block = self._block, None
        if block is not None:
            self.driver.deregister(block)

    def typed(self, keys: bytes) -> bytes:
        """Send what was typed, Ctrl-U and Ctrl-T as the bursts they stand for; what to show of it here."""
        return b"".join([self.send(_BURSTS.get(part, part)) for part in _KEYS.split(keys) if part])

    def send(self, data: bytes) -> bytes:
        """Send these bytes as they are; what to show of them here: all of them with echo."""
        for part in messages(data):
            self._put(part)
        return data if self.echo else b""

    def received(self) -> bytes:
        """Return the bytes received since the last call; with loop, also send them back. Fills `complaints`."""
        block = self._block
        if block is None:
            return b""
        self._note(block)
        frames = [frame for frame in block.retrieve() if not frame.remote]
        if self.loop:
            for frame in frames:
                self._put(frame.data)
        return b"".join([frame.data for frame in frames])

    def check(self) -> None:
        """Raises HubLost or Unplugged if nothing can come any more."""
        if self._block is not None:
            self._block.wait(0)

    def _put(self, data: bytes) -> None:
        try:
            self.driver.send(Frame(identifier(self.remote), data), _PRIORITY, _PATIENCE_S)
        except QueueFull as error:
            self.complaints.append(f"not sent: {data!r}: {error}")

    def _note(self, block: TaskBlock) -> None:
        found = news(block)
        for line in found.lines:
            if line not in self.complaints:
                self.complaints.append(line)
        if found.bus_off:
            self.driver.bus_on()
            self.complaints.append("on the bus again; what was waiting to be sent is lost")


def messages(data: bytes) -> Iterator[bytes]:
    """The bytes in messages of 8; the last one has what is left."""
    for start in range(0, len(data), _LARGEST):
        yield data[start : start + _LARGEST]


class Printable:
    """Received bytes as text that a screen can take: no control characters but line ends, tab and bell."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._after_cr = False

    def text(self, data: bytes) -> str:
        """CR, LF and CR LF are one line end each; others of C0 stand as ^A. A character may come in pieces."""
        return "".join([self._shown(character) for character in self._decoder.decode(data)])

    def _shown(self, character: str) -> str:
        after_cr, self._after_cr = self._after_cr, character == "\r"
        if character == "\n":
            return "" if after_cr else "\n"
        if character == "\r":
            return "\n"
        if character in "\t\a\b" or (character >= " " and not "\x7f" <= character < "\xa0"):
            return character
        return f"^{chr(ord(character) ^ 0x40)}" if character <= "\x7f" else "."
