"""The addresses on a bus: the claims that were received, and the addresses that this server's sockets use.

The claims themselves are sent by programs (j1939acd); a claim holds 250 ms after it was on the bus.
Source: SAE J1939-81 4.5, Linux' Documentation/networking/j1939.rst, "Dynamic addressing".
"""

from __future__ import annotations

import errno
from collections import Counter
from collections.abc import Callable
from typing import Protocol

from canwire.socketcan.j1939.message import (
    ADDRESS_CLAIMED,
    IDLE_ADDRESS,
    NO_ADDRESS,
    NO_NAME,
    Message,
    is_one_s,
)
from canwire.socketcan.ports import refuse

CLAIM_S = 0.25
_NAME_SIZE = 8


class Cancellable(Protocol):
    def cancel(self) -> None: ...


class Timers(Protocol):
    """loop.py's."""

    def call_in(self, seconds: float, call: Callable[[], object]) -> Cancellable: ...


class Addresses:
    """The addresses of one bus."""

    def __init__(self, timers: Timers) -> None:
        self._timers = timers
        self._wanted: dict[int, int] = {}  # by name: the address that it has claimed last
        self._holders: dict[int, int] = {}  # by address: the name whose claim holds
        self._pending: dict[int, Cancellable] = {}
        self._users: Counter[int] = Counter()  # sockets here, by address ...
        self._named: Counter[int] = Counter()  # ... and by name

    def use(self, name: int, address: int) -> None:
        """A socket of this server was bound to this name and address."""
        self._users[address] += 1
        self._named[name] += 1

    def leave(self, name: int, address: int) -> None:
        """A socket of this server is no longer bound to them."""
        self._users[address] -= 1
        self._named[name] -= 1

    def is_local(self, address: int) -> bool:
        """True if a socket of this server has this address, so that messages to it are received."""
        if not is_one_s(address):
            return False
        name = self._holders.get(address, NO_NAME)
        return self._users[address] > 0 or (name != NO_NAME and self._named[name] > 0)

    def name_of(self, address: int) -> int:
        """The name of the holder of this address; 0: no holder is known."""
        return self._holders.get(address, NO_NAME)

    def address_of(self, name: int) -> int:
        """The address that this name holds; IDLE_ADDRESS: none."""
        address = self._wanted.get(name, IDLE_ADDRESS)
        return address if self._holders.get(address) == name else IDLE_ADDRESS

    def heard(self, message: Message) -> None:
        """A claim was on the bus; the smaller name wins."""
        name, address = int.from_bytes(message.data, "little"), message.source
        known = name in self._wanted or self._named[name] > 0
        if len(message.data) != _NAME_SIZE or not name or not (known or is_one_s(address)):
            return
        self._withdraw(name)
        if not is_one_s(address):
            self._release(name)
            self._wanted[name] = IDLE_ADDRESS
            return
        if self._wanted.get(name) != address:
            self._release(name)
        self._wanted[name] = address
        rivals = [other for other in (*self._pending, self._holders.get(address, name)) if other != name]
        rivals = [other for other in rivals if self._wanted.get(other) == address]
        if any(other < name for other in rivals):
            return
        for other in rivals:
            self._withdraw(other)
        self._holders.pop(address, None)
        self._pending[name] = self._timers.call_in(CLAIM_S, lambda: self._settle(name))

    def resolved(self, message: Message) -> tuple[int, int]:
        """The message with its source and destination addresses; raises OSError if a name has no address."""
        source, destination = message.source, message.destination
        if message.pgn == ADDRESS_CLAIMED:
            self._check_claim(message)
        elif message.source_name:
            source = self.address_of(message.source_name)
            if not is_one_s(source) and not message.requests_claims:
                raise refuse(errno.EADDRNOTAVAIL)
        if message.destination_name:
            destination = self.address_of(message.destination_name)
            if not is_one_s(destination):
                raise refuse(errno.EADDRNOTAVAIL)
        return source, destination

    def forget(self) -> None:
        """The bus was taken down: discard all claims."""
        for name in list(self._pending):
            self._withdraw(name)
        self._holders.clear()

    def _check_claim(self, message: Message) -> None:
        """Check an address claim that is sent here; from now on nothing else is sent from the old address of its
        name.
        """
        name = int.from_bytes(message.data, "little")
        own = len(message.data) == _NAME_SIZE and name == message.source_name
        if not own or message.source == NO_ADDRESS or not message.is_broadcast:
            raise refuse(errno.EPROTO)
        if not self._named[name] and name not in self._wanted:
            raise refuse(errno.ENODEV)
        if self._wanted.get(name, IDLE_ADDRESS) != message.source:
            self._release(name)

    def _settle(self, name: int) -> None:
        self._pending.pop(name, None)
        self._holders.setdefault(self._wanted[name], name)

    def _withdraw(self, name: int) -> None:
        timer = self._pending.pop(name, None)
        if timer is not None:
            timer.cancel()

    def _release(self, name: int) -> None:
        address = self._wanted.get(name, IDLE_ADDRESS)
        if self._holders.get(address) == name:
            del self._holders[address]
