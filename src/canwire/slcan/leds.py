"""The dongle's two LEDs: when they are lit, and what they have shown.

Source: CANBUS manual, 1.2 (three blinks about a second after power-up, green for each frame) and the F command's page.
"""

from __future__ import annotations

from collections import deque
from enum import Enum
from typing import NamedTuple

from canwire.slcan.flags import BUS_ERROR, QUIET

POWER_UP_AFTER_NS = 1_000_000_000
POWER_UP_BLINKS = 3
BLINK_NS = 100_000_000  # on for so long, off for so long: the power-up's; the length of others is ours
FLASH_NS = 20_000_000  # green, after a frame
RED_BLINK_NS = 250_000_000
REMEMBERED = 64


class Red(Enum):
    """The meaning of the red LED."""

    OFF = "off"
    BLINKING = "blinking"
    CONSTANT = "constant"


class LedEvent(NamedTuple):
    """A change at a time of the dongle's clock: `led` is "both", "green" or "red"."""

    time_ns: int
    led: str
    what: str


class Leds:
    """The state of the LEDs by time in ns of the dongle's clock; `events` are the last changes except for frames."""

    def __init__(self, power_up_ns: int) -> None:
        self.red = Red.OFF
        self.frames = 0
        self.events: deque[LedEvent] = deque(maxlen=REMEMBERED)
        self._blinks_ns = power_up_ns + POWER_UP_AFTER_NS
        self._flash_end_ns = power_up_ns
        self._red_since_ns = power_up_ns
        for k in range(POWER_UP_BLINKS):
            self.events.append(LedEvent(self._blinks_ns + 2 * k * BLINK_NS, "both", "blink"))

    def frame(self, now_ns: int) -> None:
        """A frame was sent or received: a green flash."""
        self.frames += 1
        self._flash_end_ns = now_ns + FLASH_NS

    def show(self, flags: int, now_ns: int) -> None:
        """The F byte has changed: a bus error lights the red LED; a lost arbitration does not."""
        red = Red.CONSTANT if flags & BUS_ERROR else Red.BLINKING if flags & ~QUIET else Red.OFF
        if red is not self.red:
            self.red = red
            self._red_since_ns = now_ns
            self.events.append(LedEvent(now_ns, "red", red.value))

    def green_lit(self, now_ns: int) -> bool:
        return now_ns < self._flash_end_ns or self._power_up(now_ns)

    def red_lit(self, now_ns: int) -> bool:
        if self.red is Red.BLINKING:
            return (now_ns - self._red_since_ns) // RED_BLINK_NS % 2 == 0
        return self.red is Red.CONSTANT or self._power_up(now_ns)

    def _power_up(self, now_ns: int) -> bool:
        phase, rest = divmod(now_ns - self._blinks_ns, 2 * BLINK_NS)
        return 0 <= phase < POWER_UP_BLINKS and rest < BLINK_NS
