"""Between a session and whom it serves: what is wanted of an adapter, and what becomes of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from canwire.drivers.outside import Trouble
from canwire.drivers.slcan_dongle.dialects import Dialect

ACCEPT_ALL = (0x00000000, 0xFFFFFFFF)  # M's and m's values after power-up


@dataclass(frozen=True)
class Setup:
    """How the channel is to be opened. `btr` "031C", None: by the bit rate alone.

    `accept`: values of M and m, None: none in particular; `enough`: with these nothing that matters would be missed.
    """

    bit_rate: int
    btr: str | None
    data_bit_rate: int | None = None
    listen_only: bool = False
    accept: tuple[int, int] | None = None
    enough: tuple[int, int] = ACCEPT_ALL

    @property
    def filter(self) -> tuple[int, int]:
        """M's and m's values."""
        return self.enough if self.accept is None else self.accept

    @property
    def told(self) -> tuple[object, ...]:
        """All that makes a difference to the adapter."""
        return self.bit_rate, self.btr, self.data_bit_rate, self.listen_only, self.filter


class Adapter(NamedTuple):
    """What an adapter said of itself."""

    dialect: Dialect
    version: str
    serial_number: str


class User(Protocol):
    """Whom a session serves. `wanted` is how the channel shall be, None: closed."""

    wanted: Setup | None

    def met(self, adapter: Adapter) -> bool:
        """It is there, and closed; False if it is not the one that is meant."""

    def opened(self) -> None:
        """On the bus as `wanted`."""

    def closed(self) -> None:
        """Off the bus."""

    def next_frame(self) -> bytes | None:
        """What to send, without CR; the same until `sent` or `given_up`."""

    def sent(self) -> None:
        """It is in the adapter's queue."""

    def given_up(self) -> None:
        """It is not, or nobody knows."""

    def flags(self, value: int) -> None:
        """What F told."""

    def trouble(self, what: Trouble, text: str) -> None:
        """One of them, as it happens."""

    def ready(self) -> bool:
        """What was written before has gone, as far as anybody knows."""

    def hopeless(self, text: str) -> None:
        """Nothing answers any more: open the port anew."""
