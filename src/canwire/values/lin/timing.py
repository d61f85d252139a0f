"""The durations of parts of LIN frames by the formulas of the specification, and the bit rate of a sync field.

Source: LIN 2.2A 2.3.2; reference/lin-protocol.md sections 1, 5 and 9.
"""

from __future__ import annotations

from collections.abc import Sequence

from canwire.errors import BadValue

AUTO_RATE = 0
LOWEST_RATE = 1_000
HIGHEST_RATE = 20_000
SECOND_PS = 1_000_000_000_000

BREAK_BITS = 13
DELIMITER_BITS = 1
FIELD_BITS = 10  # start bit, eight data bits, stop bit
HEADER_BITS = BREAK_BITS + DELIMITER_BITS + 2 * FIELD_BITS
BREAK_THRESHOLD_BITS = 11  # a slave detects a break after this many dominant bits of its bit time
SYNC_BYTE = 0x55
WAKE_BYTE = 0xF0  # five dominant bits, 250 us to 5 ms at every bit rate
WAKE_THRESHOLD_PS = 150_000_000  # a longer dominant pulse wakes a sleeping node up

_LARGEST_LENGTH = 8
_LONGEST_PERCENT = 140  # of nominal: room for longer breaks, delimiters and spaces
SYNC_TOLERANCE_PER_MILLE = 146  # 14 % of a slave's clock before it has synchronised, 0.5 % of the master's
IDLE_NS = 4_000_000_000  # without an edge for so long a node goes to sleep by itself


def checked_rate(bit_rate: int, *, auto: bool = False) -> int:
    """The bit rate in bit/s, from 1,000 to 20,000, with `auto` also 0 (detected); raises BadValue."""
    known = isinstance(bit_rate, int) and LOWEST_RATE <= bit_rate <= HIGHEST_RATE
    if not known and not (auto and bit_rate == AUTO_RATE and isinstance(bit_rate, int)):
        instead = ", or 0 to find it out" if auto else ""
        raise BadValue(f"bit_rate {bit_rate!r}: LIN runs at {LOWEST_RATE} to {HIGHEST_RATE} bit/s{instead}")
    return bit_rate


def bit_time_ps(bit_rate: int, ppm: float = 0.0) -> int:
    """The time of one bit in picoseconds, with an oscillator that deviates by `ppm` (positive: fast)."""
    return round(SECOND_PS / (bit_rate * (1.0 + ppm * 1e-6)))


def response_bits(length: int) -> int:
    """Nominal bits of a response with `length` bytes of data, checksum included."""
    return FIELD_BITS * (length + 1)


def nominal_frame_ns(bit_rate: int, length: int) -> int:
    """A frame with no spaces in it: 34 bits of header and 10 for each byte of data and the checksum."""
    return _nanoseconds(100 * (HEADER_BITS + response_bits(length)), bit_rate)


def longest_frame_ns(bit_rate: int, length: int) -> int:
    """The longest time of a frame: 1.4 times its nominal time."""
    return _nanoseconds(_LONGEST_PERCENT * (HEADER_BITS + response_bits(length)), bit_rate)


def longest_header_ns(bit_rate: int) -> int:
    """The longest time of a header: 1.4 times its nominal 34 bits."""
    return _nanoseconds(_LONGEST_PERCENT * HEADER_BITS, bit_rate)


def longest_response_bits(length: int) -> int:
    """Bits after the header by which a response must be over: 1.4 times its nominal time; length 0: unknown, so 8."""
    return _LONGEST_PERCENT * response_bits(length or _LARGEST_LENGTH) // 100


def shortest_slot_ns(bit_rate: int, length: int = _LARGEST_LENGTH, *, jitter_ns: int = 0) -> int:
    """A schedule's slot has to be longer than this: the longest frame and the master's jitter."""
    return longest_frame_ns(bit_rate, length) + jitter_ns


def usual_slot_ns(bit_rate: int, length: int = _LARGEST_LENGTH, *, base_ns: int = 5_000_000) -> int:
    """The shortest slot that a time base (5 ms) can make for such frames."""
    return (shortest_slot_ns(bit_rate, length) // base_ns + 1) * base_ns


def bit_time_of_sync(falls_ps: Sequence[int]) -> int | None:
    """The bit time in ps from the five falling edges of a sync field; None if they are no sync field.

    The edges lie 0, 2, 4, 6 and 8 bits after the first; each distance may be off by a quarter of a bit.
    """
    if len(falls_ps) != 5:
        return None
    bit_ps = (falls_ps[4] - falls_ps[0] + 4) // 8
    distances = [falls_ps[k + 1] - falls_ps[k] for k in range(4)]
    even = all(abs(distance - 2 * bit_ps) <= bit_ps // 4 for distance in distances)
    return bit_ps if even and bit_ps > 0 else None


def bit_rate_of(bit_ps: int) -> int:
    """The whole number of bit/s nearest to a bit time in ps."""
    return (SECOND_PS + bit_ps // 2) // bit_ps


def follows(own_ps: int, heard_ps: int) -> bool:
    """Whether a slave with bits of `own_ps` accepts a sync field with bits of `heard_ps`."""
    return 1000 * abs(heard_ps - own_ps) <= SYNC_TOLERANCE_PER_MILLE * own_ps


def _nanoseconds(hundredths_of_bits: int, bit_rate: int) -> int:
    """Rounded to the nearest nanosecond."""
    divisor = 100 * bit_rate
    return (hundredths_of_bits * 1_000_000_000 + divisor // 2) // divisor
