"""The mode that a program wants of a CAN line, and the LineMode that follows from it."""

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
    """A LineMode with open parts: None means the present setting of the line or its bus, else a default.

    Rates are in bit/s. A timing takes precedence over a rate, and has its own clock. `fd`: CAN FD is needed, the
    non-ISO one without `iso_fd`. With `find_rate` the line listens to find its bit rate.
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
        """The wanted bit rate in bit/s, from the timing or the rate."""
        return self.timing.bit_rate if self.timing is not None else self.bit_rate

    @property
    def data(self) -> int | None:
        """The same for the data phase."""
        return self.data_timing.bit_rate if self.data_timing is not None else self.data_bit_rate

    def mode(self, capabilities: Capabilities) -> LineMode:
        """The LineMode for a line with these capabilities, with all that the line can do. Raises BadTiming."""
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
        """True if a line with this mode has the wanted rates; False if it has no rate."""
        if mode is None or mode.timing is None:
            return False
        return self.nominal in (None, mode.timing.bit_rate) and self.data in (None, data_rate(mode))

    def at_clock(self, clock_hz: int) -> WantedMode:
        """The same with timings of the same bits for another clock; raises BadTiming if that is impossible."""
        return replace(
            self, timing=_at_clock(self.timing, clock_hz), data_timing=_at_clock(self.data_timing, clock_hz)
        )

    def at_rates_of(self, mode: LineMode | None) -> WantedMode:
        """The same with the rates of this mode for those that are open."""
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
