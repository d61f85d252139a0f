"""`canwire isotp dump`: can-isotp reassembles the messages of both directions, and only listens."""

from __future__ import annotations

import argparse
import time
from collections import deque
from contextlib import ExitStack
from typing import Any

from canwire import Frame, frame_of_record
from canwire.commands.can_line import wanted_by
from canwire.commands.console import complain
from canwire.commands.live.listening import RECORD, Listening, places_of
from canwire.commands.shared_hub import connected
from canwire.commands.transport.line import (
    add_transport_arguments,
    address_of,
    load,
    message_of,
    params_of,
    parsed_id,
)

_BATCH = 1024
_TURN_S = 0.2


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the sub-verb's arguments."""
    add_transport_arguments(parser)
    parser.add_argument("--messages", action="store_true", help="show only complete messages, no frames")
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many messages")
    parser.add_argument("--seconds", type=float, metavar="SECONDS", help="end after this time")


def run(arguments: argparse.Namespace) -> int:
    """Print until COUNT, the time is over, or Ctrl-C."""
    sides = [Side(arguments, swapped) for swapped in (True, False)]
    with ExitStack() as closing:
        hub = connected(arguments, "isotp", closing)
        listening = closing.enter_context(
            Listening(hub, places_of(hub, [arguments.line]), wanted_by(arguments))
        )
        complain(f"listening to {arguments.tx} and {arguments.rx}")
        end_s = None if arguments.seconds is None else time.monotonic() + arguments.seconds
        count = 0
        while end_s is None or time.monotonic() < end_s:
            for _, records in listening.take(_BATCH, _TURN_S):
                for record in records:
                    frame = frame_of_record(RECORD.pack(*record))
                    for side in sides:
                        count += side.show(frame, arguments.messages)
                        if arguments.count is not None and count >= arguments.count:
                            return 0
    return 0


class Side:
    """The messages that one side sends."""

    def __init__(self, arguments: argparse.Namespace, swapped: bool) -> None:
        isotp = load("isotp")
        self._isotp = isotp
        self._waiting: deque[Any] = deque()
        self._id, self._extended = parsed_id("--rx", arguments.tx if swapped else arguments.rx)
        self._address = address_of(arguments, swapped=swapped)
        self._errors: list[Exception] = []
        params = {**params_of(arguments), "listen_mode": True, "rx_consecutive_frame_timeout": 3_600_000}
        self._logic = isotp.TransportLayerLogic(
            lambda timeout: self._waiting.popleft() if self._waiting else None,
            lambda message: None,
            self._address,
            self._errors.append,
            params,
        )

    def show(self, frame: Frame, messages_only: bool) -> int:
        """Print the frame if this side sent it, and any message it completes; returns the number of messages."""
        if (frame.id, frame.extended) != (self._id, self._extended) or frame.remote:
            return 0
        message = message_of(frame, self._isotp.CanMessage)
        if not self._address.is_for_me(message):  # with another byte before it
            return 0
        if not messages_only:
            print(f"{frame.timestamp_ns / 1e9:.6f} {frame.id:03X}  {self._told(message)}")
        self._waiting.append(message)
        self._logic.process()
        for error in self._errors:
            complain(f"{frame.id:03X}: {error}")
        self._errors.clear()
        count = 0
        while (found := self._logic.recv()) is not None:
            print(
                f"{frame.timestamp_ns / 1e9:.6f} {frame.id:03X}  {len(found)} bytes  {bytes(found).hex().upper()}",
                flush=True,
            )
            count += 1
        return count

    def _told(self, message: Any) -> str:
        """Return the kind of the message in words, as isotpdump shows it."""
        try:
            pdu = self._isotp.protocol.PDU(message, self._address.get_rx_prefix_size())
        except ValueError as error:
            return f"{message.data.hex(' ').upper()}: {error}"
        kinds = pdu.Type
        if pdu.type == kinds.FLOW_CONTROL:
            state = {0: "continue to send", 1: "wait", 2: "overflow"}.get(pdu.flow_status, "?")
            return f"[FC] {state}, block size {pdu.blocksize}, {pdu.stmin:02X} between frames"
        data = bytes(pdu.data).hex(" ").upper()
        if pdu.type == kinds.CONSECUTIVE_FRAME:
            return f"[CF] {pdu.seqnum:X}  {data}"
        return f"[{'SF' if pdu.type == kinds.SINGLE_FRAME else 'FF'}] {pdu.length}  {data}"
