"""The interface between a session and its user: the settings that are wanted, and what happens to the adapter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

from canwire.drivers.outside import Trouble
from canwire.drivers.slcan_dongle.dialects import Dialect

ACCEPT_ALL = (0x00000000, 0xFFFFFFFF)  # M's and m's values after power-up


@dataclass(frozen=True)
class Setup:
    """Settings to open the channel with. `btr` is like "031C"; with None only the bit rate is set.

    `accept`: values of M and m that are required, None: none are; `enough`: values that let all wanted frames pass.
    """

    bit_rate: int
    btr: str | None
    data_bit_rate: int | None = None
    listen_only: bool = False
    accept: tuple[int, int] | None = None
    enough: tuple[int, int] = ACCEPT_ALL

    @property
    def filter(self) -> tuple[int, int]:
        """The values of M and m to set."""
        return self.enough if self.accept is None else self.accept

    @property
    def told(self) -> tuple[object, ...]:
        """The settings that change what the adapter does."""
        return self.bit_rate, self.btr, self.data_bit_rate, self.listen_only, self.filter


class Adapter(NamedTuple):
    """What an adapter reported about itself."""

    dialect: Dialect
    version: str
    serial_number: str


class User(Protocol):
    """The user of a session. `wanted` are the settings for the channel; None: it is to be closed."""

    wanted: Setup | None

    def met(self, adapter: Adapter) -> bool:
        """An adapter answers, and its channel is closed. Return False if it is not the wanted adapter."""

    def opened(self) -> None:
        """The channel was opened as `wanted`."""

    def closed(self) -> None:
        """The channel was closed."""

    def next_frame(self) -> bytes | None:
        """The next frame to send, without CR; the same one until `sent` or `given_up`."""

    def sent(self) -> None:
        """The frame is in the adapter's queue."""

    def given_up(self) -> None:
        """The frame is not in the adapter's queue, or that is unknown."""

    def flags(self, value: int) -> None:
        """The answer to F."""

    def trouble(self, what: Trouble, text: str) -> None:
        """A fault of the adapter has occurred."""

    def ready(self) -> bool:
        """True if little of what was written before still waits in the computer."""

    def hopeless(self, text: str) -> None:
        """The adapter no longer answers: open the port again."""
