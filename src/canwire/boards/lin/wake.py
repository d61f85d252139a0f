"""Wakes a LIN bus: the pulse is repeated until a master sends a header.

Source: LIN 2.2A 2.6.2; reference/lin-protocol.md section 7.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.timeline import Timeline, Timer

PULSES = 3
REPEAT_NS = 200_000_000  # from a pulse's end to the next one: 150 to 250 ms
PAUSE_NS = 1_500_000_000  # from the third pulse's end to the next one


class WakeUp:
    """Sends pulses by `pulse` until `heard`, the number of headers so far, changes; calls `failed` after every third.

    Its timers are background ones: a bus on which no node answers becomes idle between them.
    """

    def __init__(
        self,
        timeline: Timeline,
        pulse: Callable[[], None],
        heard: Callable[[], int],
        failed: Callable[[], None],
    ) -> None:
        self._timeline = timeline
        self._pulse = pulse
        self._heard = heard
        self._failed = failed
        self._timer: Timer | None = None
        self._left = 0
        self._headers = 0

    def begin(self) -> None:
        """Send the first pulse now; a sequence that runs already starts again."""
        self.cancel()
        self._headers = self._heard()
        self._send(PULSES - 1)

    def sent(self) -> None:
        """Wait for a header after a pulse."""
        self._wait(REPEAT_NS, self._look)

    def cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _send(self, left: int) -> None:
        self._left = left
        self._pulse()

    def _wait(self, span_ns: int, then: Callable[[], None]) -> None:
        self.cancel()
        self._timer = self._timeline.at(self._timeline.now_ns + span_ns, then, background=True)

    def _look(self) -> None:
        if self._heard() != self._headers:
            return
        if self._left:
            self._send(self._left - 1)
        else:
            self._failed()
            self._wait(PAUSE_NS - REPEAT_NS, self._again)

    def _again(self) -> None:
        if self._heard() == self._headers:
            self._send(PULSES - 1)
