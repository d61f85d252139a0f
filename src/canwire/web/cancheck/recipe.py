"""The recipe of a message generator: the fields of its window, and the resulting messages.

Source: CANDRV manual, 10.4, send dialog; docs/cancheck.md for what the manual does not define.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from canwire import BadValue

MOST_DATA = 8  # bytes


class Outgoing(NamedTuple):
    """A message to send. `identifier` is right-aligned, as on the bus; a remote frame has no data."""

    identifier: int
    extended: bool
    rtr: bool
    dlc: int
    data: bytes


class Range(NamedTuple):
    """Values from `first` to `last`, one by one, upwards or downwards."""

    first: int
    last: int

    @property
    def difference(self) -> int:
        return abs(self.last - self.first)

    def at(self, step: int, *, wrap: bool) -> int:
        """Return the value after `step` steps; after `last` it restarts at `first` if `wrap`, else
        it stays at `last`."""
        along = step % (self.difference + 1) if wrap else min(step, self.difference)
        return self.first + along if self.last >= self.first else self.first - along


@dataclass(frozen=True)
class Recipe:
    """The fields of one generator. Without `use_range` only the first value of each range is used.

    `data` has as many ranges as the DLC, 0 to 8; identifiers are right-aligned. Raises BadValue.
    """

    identifier: Range
    data: tuple[Range, ...] = ()
    rtr: bool = False
    extended: bool = False
    delay_ms: int = 1000
    use_range: bool = False
    wrap: bool = False
    repeat: bool = False

    def __post_init__(self) -> None:
        if len(self.data) > MOST_DATA or self.delay_ms < 0:
            raise BadValue(
                f"{len(self.data)} data bytes, delay {self.delay_ms} ms: at most {MOST_DATA}, 0 or more"
            )

    @property
    def cycle(self) -> int:
        """Number of messages in one cycle: the largest difference of all ranges, plus one."""
        return 1 + max(one.difference for one in (self.identifier, *self.data))

    @property
    def ends(self) -> bool:
        """Whether the generator pauses by itself after a cycle."""
        return self.use_range and not self.repeat

    def message(self, step: int) -> Outgoing:
        """Return the message number `step`, from 0, which has the values of From."""
        step = step if self.use_range else 0
        data = bytes(one.at(step, wrap=self.wrap) for one in self.data)
        identifier = self.identifier.at(step, wrap=self.wrap)
        return Outgoing(identifier, self.extended, self.rtr, len(data), b"" if self.rtr else data)
