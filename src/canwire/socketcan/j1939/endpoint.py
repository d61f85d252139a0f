"""The addresses that a J1939 socket is bound and connected to, which decide the messages that it receives.

Source: Linux' Documentation/networking/j1939.rst, "API Calls" and "Message Filtering".
"""

from __future__ import annotations

import errno
import os
import struct
from collections.abc import Callable
from typing import NamedTuple

from canwire.socketcan.j1939.message import (
    LARGEST_PGN,
    NO_ADDRESS,
    NO_NAME,
    NO_PGN,
    USUAL_PRIORITY,
    Message,
    is_one_s,
)
from canwire.socketcan.j1939.reports import Report
from canwire.socketcan.ports import refuse

_FILTER = struct.Struct("<QQIIBB6x")
MOST_FILTERS = 512
_PRIVILEGED = 2  # priorities below are an administrator's


class Filter(NamedTuple):
    """struct j1939_filter."""

    name: int
    name_mask: int
    pgn: int
    pgn_mask: int
    address: int
    address_mask: int

    def passes(self, message: Message) -> bool:
        return (
            (message.pgn ^ self.pgn) & self.pgn_mask == 0
            and (message.source ^ self.address) & self.address_mask == 0
            and (message.source_name ^ self.name) & self.name_mask == 0
        )


def parse_filters(value: bytes) -> list[Filter]:
    """The filters in a value of SO_J1939_FILTER; raises OSError."""
    if len(value) % _FILTER.size or len(value) > MOST_FILTERS * _FILTER.size:
        raise refuse(errno.EINVAL)
    return [Filter(*fields) for fields in _FILTER.iter_unpack(value)]


def checked_priority(number: int) -> int:
    """The priority in a value of SO_J1939_SEND_PRIO; raises OSError."""
    if not 0 <= number <= 7:
        raise refuse(errno.EDOM)
    if number < _PRIVILEGED and os.geteuid() != 0:
        raise refuse(errno.EPERM)
    return number


class Endpoint:
    """`broadcasts` returns whether SO_BROADCAST is set; `deliver` and `report` pass results to the program."""

    def __init__(
        self,
        broadcasts: Callable[[], bool],
        deliver: Callable[[Message, int, bool], object],
        report: Callable[[Report], object],
    ) -> None:
        self.broadcasts = broadcasts
        self.deliver = deliver
        self.report = report
        self.connected = False
        self.promiscuous = False
        self.name = self.peer_name = NO_NAME
        self.address = self.peer_address = NO_ADDRESS
        self.pgn = self.pgn_heard = NO_PGN
        self.priority = USUAL_PRIORITY
        self.filters: list[Filter] = []

    def hears(self, message: Message) -> bool:
        if not self.promiscuous and not (self._is_for_it(message) and self._is_of_peer(message)):
            return False
        return not self.filters or any(one.passes(message) for one in self.filters)

    def _is_for_it(self, message: Message) -> bool:
        if self.pgn_heard <= LARGEST_PGN and self.pgn_heard != message.pgn:
            return False
        if self.name and message.destination_name:
            return self.name == message.destination_name
        if is_one_s(message.destination):
            return self.address == message.destination
        return self.broadcasts()

    def _is_of_peer(self, message: Message) -> bool:
        if not self.connected:
            return True
        if self.peer_name and message.source_name:
            return self.peer_name == message.source_name
        return self.peer_address == message.source

    def message(self, data: bytes, pgn: int, destination_name: int, destination: int) -> Message:
        """The message to send; the connection supplies a missing PGN (NO_PGN) or destination."""
        if not destination_name and destination == NO_ADDRESS:
            destination_name, destination = self.peer_name, self.peer_address
        return Message(
            pgn if pgn <= LARGEST_PGN else self.pgn,
            self.address,
            destination,
            data,
            self.priority,
            self.name,
            destination_name,
        )
