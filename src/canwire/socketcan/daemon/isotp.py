"""The ISO-TP mode of a client: one channel of two identifiers, set up by isotpconf, and its messages as text.

Source: linux-can/socketcand, doc/protocol.md, and its state_isotp.c for details that the document leaves open.
"""

from __future__ import annotations

import errno
import re
import struct
from typing import TYPE_CHECKING

from canwire import BadText
from canwire.socketcan.daemon.words import identifier, number, time_of
from canwire.socketcan.isotp import layout
from canwire.socketcan.isotp.options import (
    EXTEND_ADDR,
    LARGEST_PDU,
    RX_EXT_ADDR,
    RX_PADDING,
    SF_BROADCAST,
    TX_PADDING,
    USUAL_PAD,
    Options,
)
from canwire.socketcan.isotp.receiver import Receiver
from canwire.socketcan.isotp.sender import Sender, State

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from canwire.socketcan.isotp.sender import Timers

_KNOWN_FLAGS = 0x1FFF
_MOST_WAITING = 1 << 20  # bytes of messages that wait for the one on its way
_HEAD = struct.Struct("<IBxxx8s")
_HEX = re.compile(r"(?:[0-9A-Fa-f]{2})+")
_NEEDED = {TX_PADDING: 6, RX_PADDING: 7, EXTEND_ADDR: 8, RX_EXT_ADDR: 9}  # words, by flag


def options_of(words: Sequence[str]) -> tuple[int, int, Options]:
    """The values of isotpconf: the identifier to send with, the one to receive, and the options. Raises BadText."""
    if not 6 <= len(words) <= 11:
        raise BadText("isotpconf: tx_id rx_id flags blocksize stmin, and up to five more")
    sends, receives = identifier(words[1]), identifier(words[2])
    if sends == receives:
        raise BadText("isotpconf: two identifiers")
    flags = number(words[3], 16, _KNOWN_FLAGS)
    missing = [f"{flag:#x}" for flag, place in _NEEDED.items() if flags & flag and len(words) <= place + 1]
    if missing:
        raise BadText(f"isotpconf: too few words for flag {', '.join(missing)}")
    bases = (16, 10, 16, 10, 16, 16, 16, 16)  # flags, blocksize, stmin, wftmax, paddings, addresses
    values = [
        number(word, base, 0xFF if at else _KNOWN_FLAGS)
        for at, (word, base) in enumerate(zip(words[3:], bases, strict=False))
    ]
    values += [0, 0, 0, 0, USUAL_PAD, USUAL_PAD, 0, 0][len(values) :]
    _, block, stmin, waits, tx_pad, rx_pad, address, rx_address = values
    return sends, receives, Options(
        flags=flags, block_size=block, stmin=stmin, most_waits=waits, tx_pad=tx_pad, rx_pad=rx_pad,
        address=address, rx_address=rx_address,
    )  # fmt: skip


def pdu_of(words: Sequence[str]) -> bytes:
    """The message of a sendpdu command. Raises BadText."""
    if len(words) != 2 or not _HEX.fullmatch(words[1]) or len(words[1]) > 2 * LARGEST_PDU:
        raise BadText(f"sendpdu: 1 to {LARGEST_PDU} bytes, two hex digits each")
    return bytes.fromhex(words[1])


class IsoTp:
    """`put` sends a frame, `tell` sends a text to the client. Messages are sent one after the other."""

    def __init__(
        self,
        timers: Timers,
        words: Sequence[str],
        put: Callable[[bytes], object],
        tell: Callable[[str], object],
    ) -> None:
        self._sends, self.receives, self._options = options_of(words)
        self._put, self._tell = put, tell
        self._sender = Sender(timers, self._send_frame, self._sent)
        self._receiver = Receiver(timers, self._send_frame, self._deliver, self._failed)
        self._sender.options = self._receiver.options = self._options
        self._waiting: list[bytes] = []

    def send(self, message: bytes) -> None:
        """Send a message after the earlier ones. Raises BadText if it cannot be sent."""
        if not self._sender.fits(len(message)):
            raise BadText(f"sendpdu: {len(message)} bytes are too many for this channel")
        if self._sender.state is State.IDLE:
            self._sender.send(message)
        elif sum(map(len, self._waiting)) > _MOST_WAITING:
            raise BadText("sendpdu: too many messages wait")
        else:
            self._waiting.append(message)

    def take(self, can_id: int, data: bytes, stamp_ns: int, own: bool) -> None:
        """Process a classic frame of the bus; `own`: this client sent it."""
        if own:
            self._sender.confirm(int(can_id == self._sends))
            return
        ahead = self._options.extended
        if (
            can_id != self.receives
            or len(data) <= ahead
            or (ahead and data[0] != self._options.address_heard)
        ):
            return
        if data[ahead] & 0xF0 == layout.FLOW_CONTROL:
            self._sender.flow_control(data[ahead:])
        elif not self._options.flags & SF_BROADCAST:
            self._receiver.take(data, stamp_ns)

    def stop(self) -> None:
        """Stop sending and reporting."""
        self._waiting.clear()
        self._receiver.stop()
        self._sender.stop()

    def _send_frame(self, data: bytes) -> None:
        self._put(_HEAD.pack(self._sends, len(data), data))

    def _sent(self, error: int) -> None:
        if error:
            self._failed(error)
        if self._waiting:
            self._sender.send(self._waiting.pop(0))

    def _deliver(self, message: bytes, stamp_ns: int) -> None:
        self._tell(f"< pdu {time_of(stamp_ns)} {message.hex().upper()} >")

    def _failed(self, error: int) -> None:
        self._tell(f"< error pdu {errno.errorcode.get(error, error)} >")
