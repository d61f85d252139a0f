"""The settings of a dongle, and its counters."""

from __future__ import annotations

import re
from dataclasses import dataclass

from canwire import BadValue, BitTiming
from canwire.slcan.can_side import ACCEPT_ALL
from canwire.slcan.dialects import CANBUS, Dialect

OUTPUT_SIZE = 65_536  # bytes on their way to the host: USB's and its driver's buffers
_LONGEST_VERSION = 100


@dataclass(frozen=True, slots=True)
class Settings:
    """`tx_reply` "z": z or Z and CR for a queued frame, "cr": only CR. `version` "" is the default of the dialect.

    Raises BadValue.
    """

    serial_number: str = "A123"
    version: str = ""
    tx_reply: str = "z"
    dialect: Dialect = CANBUS
    output_size: int = OUTPUT_SIZE

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[0-9A-Za-z]{4}", self.serial_number):
            raise BadValue(f"serial number {self.serial_number!r}: four letters or digits")
        if self.tx_reply not in ("z", "cr"):
            raise BadValue(f"transmit reply {self.tx_reply!r}: z or cr")
        if not self.version:
            object.__setattr__(self, "version", self.dialect.version)
        if self.dialect is CANBUS and not re.fullmatch(r"V[0-9]{4}", self.version):
            raise BadValue(f"version {self.version!r}: V and four digits, V1013 perhaps")
        if (
            not (self.version.isascii() and self.version.isprintable())
            or len(self.version) > _LONGEST_VERSION
        ):
            raise BadValue(f"version {self.version!r}: one short line of ASCII")


@dataclass(slots=True)
class DongleCounters:
    """Counts since power-up. Of the frames for the host, `received` reached its buffer and `lost` found the queue full.
    `refused` frames of the host found eight others waiting. `replies_lost` did not fit, since the host reads nothing.
    `errors` of the `commands` were answered with BELL."""

    commands: int = 0
    errors: int = 0
    sent: int = 0
    received: int = 0
    lost: int = 0
    refused: int = 0
    replies_lost: int = 0

    @property
    def summary(self) -> str:
        """The counters as text for display."""
        return (
            f"sent {self.sent}, refused {self.refused}, received {self.received}, lost {self.lost}, "
            f"replies lost {self.replies_lost}"
        )

    @property
    def losses(self) -> int:
        """The number of frames and replies that did not arrive."""
        return self.refused + self.lost + self.replies_lost


@dataclass(slots=True)
class Chosen:
    """The settings for the next opening, from S, s, M, m and similar commands."""

    timing: BitTiming | None
    data_timing: BitTiming | None
    code: bytes = ACCEPT_ALL[0]
    mask: bytes = ACCEPT_ALL[1]
    silent: bool = False
    single_shot: bool = False
