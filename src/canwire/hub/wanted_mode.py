"""What a program asks of a CAN line, and how the line is set up for that."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import ClassVar

from canwire.boards.can.modes import LineMode, LineStatus
from canwire.boards.can.rates import data_rate
from canwire.boards.description import Capabilities, Feature
from canwire.errors import BadTiming
from canwire.values.frozen import dataclass
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import check_data_rate


@dataclass(frozen=True, slots=True)
class WantedMode:
    """A LineMode with parts left open: None takes what is there, or what is usual.

    Rates are in bit/s; a timing counts before a rate, and at its own clock. `fd`: CAN FD is needed, before ISO
    without `iso_fd`. With `find_rate` the line listens to find its bit rate.
    """

    USUAL_BIT_RATE: ClassVar[int] = 500_000
    USUAL_DATA_BIT_RATE: ClassVar[int] = 2_000_000

    bit_rate: int | None = None
    data_bit_rate: int | None = None
    timing: BitTiming | None = None
    data_timing: BitTiming | None = None
    fd: bool = False
    iso_fd: bool = True
    listen_only: bool = False
    find_rate: bool = False

    @property
    def nominal(self) -> int | None:
        """The bit rate asked for, in bit/s, by whichever means."""
        return self.timing.bit_rate if self.timing is not None else self.bit_rate

    @property
    def data(self) -> int | None:
        """The same of the data phase."""
        return self.data_timing.bit_rate if self.data_timing is not None else self.data_bit_rate

    def mode(self, capabilities: Capabilities) -> LineMode:
        """How such a line is set up: with everything that it can. Raises BadTiming."""
        errors = capabilities.can(Feature.ERROR_FRAMES)
        if self.find_rate:
            return LineMode(None, error_frames=errors, listen_only=self.listen_only)
        asked = self.at_clock(capabilities.clock_hz)
        timing = asked.timing or capabilities.timing(self.bit_rate or self.USUAL_BIT_RATE)
        data = None
        if capabilities.data is not None:
            rate = self.data_bit_rate or max(self.USUAL_DATA_BIT_RATE, timing.bit_rate)
            data = asked.data_timing or capabilities.data_timing(rate)
            if self.data is not None:
                check_data_rate(timing.bit_rate, data.bit_rate)
        return LineMode(
            timing,
            data,
            long_data=data is not None,
            iso_fd=self.iso_fd,
            error_frames=errors,
            listen_only=self.listen_only,
        )

    def rates_agree(self, mode: LineMode | None) -> bool:
        """Whether a line that is set up so has the rates asked for; False while it has none at all."""
        if mode is None or mode.timing is None:
            return False
        return self.nominal in (None, mode.timing.bit_rate) and self.data in (None, data_rate(mode))

    def at_clock(self, clock_hz: int) -> WantedMode:
        """The same with timings of the same bits by another clock; raises BadTiming where that cannot be."""
        return replace(
            self, timing=_at_clock(self.timing, clock_hz), data_timing=_at_clock(self.data_timing, clock_hz)
        )

    def at_rates_of(self, mode: LineMode | None) -> WantedMode:
        """The same with the rates that were left open taken over from there."""
        if mode is None or mode.timing is None:
            return self
        return replace(
            self,
            bit_rate=self.bit_rate or mode.timing.bit_rate,
            data_bit_rate=self.data_bit_rate or data_rate(mode),
        )

    def at_rates_on_bus(self, statuses: Iterable[LineStatus]) -> WantedMode:
        """The same with the rates of a bus's running lines, unless the line is to find its own."""
        wanted = self
        for status in statuses:
            if status.running and not self.find_rate:
                wanted = wanted.at_rates_of(status.mode)
        return wanted


def _at_clock(timing: BitTiming | None, clock_hz: int) -> BitTiming | None:
    if timing is None or timing.clock_hz == clock_hz:
        return timing
    prescaler, rest = divmod(timing.prescaler * clock_hz, timing.clock_hz)
    if rest:
        raise BadTiming(f"{timing}: the clock of this line is {clock_hz} Hz")
    return replace(timing, prescaler=prescaler, clock_hz=clock_hz)
