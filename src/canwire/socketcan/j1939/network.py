"""The J1939 traffic of one bus: received frames go to address claims, to unfinished messages, and to sockets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from canwire.socketcan.j1939.addresses import Addresses, Timers
from canwire.socketcan.j1939.codes import (
    ABORT,
    BAM,
    DPO,
    ETP,
    KINDS,
    LARGEST_ETP,
    LARGEST_TP,
    PAD,
    TP,
    Abort,
    Kind,
    error_of,
)
from canwire.socketcan.j1939.endpoint import Endpoint
from canwire.socketcan.j1939.message import (
    ADDRESS_CLAIMED,
    NO_ADDRESS,
    Message,
    has_destination,
)
from canwire.socketcan.j1939.receiving import Receiving, announced, refusal
from canwire.socketcan.j1939.reports import Report, What
from canwire.socketcan.j1939.sending import Sending
from canwire.socketcan.j1939.transfer import Transfer, reversed_message

_Key = tuple[Kind, int, int]  # source and destination of the message


class Network:
    """`put` sends a frame for an endpoint (None: for the receivers here); `largest`: the most bytes in a message."""

    def __init__(
        self,
        timers: Timers,
        put: Callable[[Message, Endpoint | None], object],
        largest: int = LARGEST_ETP,
    ) -> None:
        self.timers = timers
        self.put = put
        self.addresses = Addresses(timers)
        self.endpoints: list[Endpoint] = []
        self._largest = largest
        self._sendings: dict[_Key, Sending] = {}
        self._receivings: dict[_Key, Receiving] = {}
        self._received = 0  # messages of several frames, for the error queues

    # what sockets send

    def is_busy(self, message: Message) -> bool:
        """True if a message of this kind is in transit between the same addresses."""
        kind = ETP if len(message.data) > LARGEST_TP else TP
        return (kind, message.source, message.destination) in self._sendings

    def add(self, sending: Sending) -> None:
        self._sendings[_key_of(sending)] = sending

    def forget(self, sending: Sending) -> None:
        """Remove a finished message; a second call has no effect."""
        self._sendings.pop(_key_of(sending), None)

    def stop(self, error: int) -> None:
        """The bus was taken down: end messages that are being received; the senders' sockets end the others."""
        self.addresses.forget()
        for receiving in list(self._receivings.values()):
            receiving.end(error)

    # what is heard

    def take(self, message: Message, stamp_ns: int, sender: Endpoint | None, own: bool) -> None:
        """A frame was on the bus; `own`: this computer's, `sender`: this socket's, where it is a J1939 one."""
        if message.source == NO_ADDRESS:
            return
        message = self._with_names(message)
        if self._take_transport(message, stamp_ns):
            return
        for endpoint in list(self.endpoints):
            if endpoint is not sender and endpoint.hears(message):
                endpoint.deliver(message, stamp_ns, own)

    def _with_names(self, message: Message) -> Message:
        if message.pgn == ADDRESS_CLAIMED:
            self.addresses.heard(message)
            name = int.from_bytes(message.data, "little") if len(message.data) == 8 else 0
        else:
            name = self.addresses.name_of(message.source)
        return replace(
            message, source_name=name, destination_name=self.addresses.name_of(message.destination)
        )

    def _take_transport(self, message: Message, stamp_ns: int) -> bool:
        """Process a part of a longer message from or to here, or to all; False if the message is no such part."""
        kind = next((one for one in KINDS if message.pgn in (one.control, one.data)), None)
        sends, receives = (
            self.addresses.is_local(message.source),
            self.addresses.is_local(message.destination),
        )
        if kind is None or not (sends or receives or message.is_broadcast):
            return False
        if message.pgn == kind.data:
            self._take_data(kind, message, stamp_ns)
        elif len(message.data) < 8:
            return False
        else:
            self._take_control(kind, message, sends, receives)
        return True

    def _take_data(self, kind: Kind, message: Message, stamp_ns: int) -> None:
        key = kind, message.source, message.destination
        if key in self._sendings:
            self._sendings[key].confirm(message.pgn)
        if key in self._receivings:
            self._receivings[key].take(message.data, stamp_ns)

    def _take_control(self, kind: Kind, message: Message, sends: bool, receives: bool) -> None:
        command = message.data[0]
        if command == BAM and not kind.extended:
            if message.is_broadcast:
                self._announced(kind, message)
        elif message.is_broadcast:
            return
        elif command == kind.rts:
            if receives:
                self._announced(kind, message)
        elif command == ABORT:
            self._aborted(kind, message)
        elif command == DPO and kind.extended:
            self._offset(message)
        elif receives and command in (kind.cts, kind.eom):
            self._answered(kind, message)

    def _announced(self, kind: Kind, message: Message) -> None:
        """Process the announcement of a message (RTS or BAM)."""
        pgn = _pgn_of(message.data)
        key = kind, message.source, message.destination
        before = self._receivings.get(key)
        if before is not None and not message.is_broadcast:
            if before.message.pgn == pgn:
                before.fail(Abort.BUSY)
            else:
                self._refuse(kind, message, Abort.BUSY)
            return
        if before is not None:
            before.end(error_of(Abort.BUSY))
        what = announced(kind, message.data)
        coming = replace(message, pgn=pgn, data=b"")
        if not self._wanted(coming):
            return
        reason = refusal(kind, what.size, self._largest)
        if reason is not None:
            self._refuse(kind, message, reason)
            return
        receiving = self._receivings[key] = self._made(kind, coming, key, message)
        receiving.begin()

    def _made(self, kind: Kind, coming: Message, key: _Key, first: Message) -> Receiving:
        number, self._received = self._received, self._received + 1

        def tell(what: What, error: int | None = None) -> None:
            done = receiving.received_size
            report = Report(what, number, coming, receiving.size, done)
            for endpoint in self._hearing(coming):
                endpoint.report(report if error is None else report._replace(error=error))

        def over(error: int) -> None:
            self._receivings.pop(key, None)
            if error:
                tell(What.LOST, error)
                return
            whole = replace(coming, data=bytes(receiving.data))
            for endpoint in self._hearing(coming):
                endpoint.deliver(whole, receiving.stamp_ns, False)

        def put(frame: Message) -> None:
            self.put(frame, None)

        what = announced(kind, first.data)
        receiving = Receiving(self.timers, kind, coming, what, put, over, lambda: self._wanted(coming))
        receiving.on_offset = lambda: tell(What.OFFSET)
        tell(What.ANNOUNCED)
        return receiving

    def _offset(self, message: Message) -> None:
        receiving = self._receivings.get((ETP, message.source, message.destination))
        if receiving is None:
            return
        if self._is_of(receiving, message, Abort.BAD_DPO_PGN):
            receiving.offset(message.data)

    def _answered(self, kind: Kind, message: Message) -> None:
        """Process CTS or the acknowledgement of a message that is sent from here."""
        sending = self._sendings.get((kind, message.destination, message.source))
        if sending is None:
            return
        if message.data[0] == kind.eom:
            if self._is_of(sending, message, Abort.OTHER):
                sending.acknowledged()
        elif self._is_of(sending, message, Abort.BAD_CTS_PGN):
            sending.clear_to_send(message.data)

    def _aborted(self, kind: Kind, message: Message) -> None:
        """Process an abort by either side, of a message in either direction."""
        there, back = (
            (kind, message.source, message.destination),
            (kind, message.destination, message.source),
        )
        found: list[Transfer | None] = [
            self._sendings.get(there),
            self._sendings.get(back),
            self._receivings.get(there),
            self._receivings.get(back),
        ]
        for transfer in found:
            if transfer is not None and transfer.message.pgn == _pgn_of(message.data):
                transfer.aborted(message.data)

    def _is_of(self, transfer: Transfer, message: Message, otherwise: Abort) -> bool:
        """True if the frame names the PGN of this transfer; else refuse it."""
        same = transfer.message.pgn == _pgn_of(message.data)
        if not same:
            self._refuse(transfer.kind, message, otherwise)
        return same

    def _refuse(self, kind: Kind, message: Message, reason: Abort) -> None:
        """Send an abort to the sender of this frame."""
        if not message.is_broadcast:
            data = bytes((ABORT, reason)).ljust(5, bytes((PAD,))) + message.data[5:8]
            self.put(replace(reversed_message(message), pgn=kind.control, data=data), None)

    def _hearing(self, message: Message) -> list[Endpoint]:
        return [endpoint for endpoint in self.endpoints if endpoint.hears(message)]

    def _wanted(self, message: Message) -> bool:
        return any(endpoint.hears(message) for endpoint in self.endpoints)


def _key_of(transfer: Transfer) -> _Key:
    return transfer.kind, transfer.message.source, transfer.message.destination


def _pgn_of(data: bytes) -> int:
    """The PGN of the message that a control frame concerns."""
    pgn = int.from_bytes(data[5:8], "little")
    return pgn & 0xFFFF00 if has_destination(pgn) else pgn
