"""What somebody asks of a line, and how it is set up for that."""

from __future__ import annotations

from dataclasses import dataclass, replace

from canwire import BadTiming, BitTiming, Capabilities, Feature, LineMode, TimingRange

USUAL_BIT_RATE = 500_000
USUAL_DATA_BIT_RATE = 2_000_000
_FEWEST_QUANTA = 8, 5  # of a bit in the nominal and in the data phase: values/timing/limits.py


@dataclass(frozen=True, slots=True)
class Wanted:
    """What somebody asks of a line; None: whatever there is, or is usual."""

    bit_rate: int | None = None
    data_bit_rate: int | None = None
    timing: BitTiming | None = None
    data_timing: BitTiming | None = None
    fd: bool = False
    iso_fd: bool = True
    listen_only: bool = False
    exclusive: bool = False
    find_rate: bool = False

    @property
    def nominal(self) -> int | None:
        return self.timing.bit_rate if self.timing is not None else self.bit_rate

    @property
    def data(self) -> int | None:
        return self.data_timing.bit_rate if self.data_timing is not None else self.data_bit_rate


def rates_text(mode: LineMode | None) -> str:
    """`500000 bit/s, 2000000 after BRS`"""
    if mode is None or mode.timing is None:
        return "no bit rate yet"
    data = mode.data_timing
    after = f", {data.bit_rate} after BRS" if data is not None else ""
    return f"{mode.timing.bit_rate} bit/s{after}{', listening only' if mode.listen_only else ''}"


def line_mode(capabilities: Capabilities, wanted: Wanted) -> LineMode:
    """How a line is set up: with everything that it can. Raises BadTiming."""
    errors = capabilities.can(Feature.ERROR_FRAMES)
    if wanted.find_rate:
        return LineMode(None, error_frames=errors, listen_only=wanted.listen_only)
    nominal_least, data_least = _FEWEST_QUANTA
    timing = at_clock(wanted.timing, capabilities) or _timing(
        wanted.bit_rate or USUAL_BIT_RATE, capabilities, capabilities.nominal, nominal_least
    )
    data = None
    if capabilities.data is not None:
        rate = wanted.data_bit_rate or max(USUAL_DATA_BIT_RATE, timing.bit_rate)
        data = at_clock(wanted.data_timing, capabilities) or _timing(
            rate, capabilities, capabilities.data, data_least
        )
    return LineMode(
        timing,
        data,
        long_data=data is not None,
        iso_fd=wanted.iso_fd,
        error_frames=errors,
        listen_only=wanted.listen_only,
    )


def at_rates_of(mode: LineMode | None, wanted: Wanted) -> Wanted:
    """What is left open is taken over."""
    if mode is None or mode.timing is None:
        return wanted
    data = mode.data_timing.bit_rate if mode.data_timing is not None else None
    bit_rate, data_bit_rate = wanted.bit_rate or mode.timing.bit_rate, wanted.data_bit_rate or data
    return replace(wanted, bit_rate=bit_rate, data_bit_rate=data_bit_rate)


def at_clock(timing: BitTiming | None, capabilities: Capabilities) -> BitTiming | None:
    """The same bits at the line's own clock; raises BadTiming where that cannot be."""
    if timing is None or timing.clock_hz == capabilities.clock_hz:
        return timing
    prescaler, rest = divmod(timing.prescaler * capabilities.clock_hz, timing.clock_hz)
    if rest:
        raise BadTiming(f"{timing}: the clock of this line is {capabilities.clock_hz} Hz")
    return replace(timing, prescaler=prescaler, clock_hz=capabilities.clock_hz)


def _timing(bit_rate: int, capabilities: Capabilities, registers: TimingRange, quanta_min: int) -> BitTiming:
    limits = registers.limits(quanta_min=quanta_min)
    return BitTiming.for_bit_rate(bit_rate, clock_hz=capabilities.clock_hz, limits=limits)
