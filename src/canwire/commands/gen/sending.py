"""Sends frames on a line at given times, and counts the outcomes."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from canwire import Frame, HubError
from canwire.commands.send import Sending

if TYPE_CHECKING:
    from canwire import Hub, HubChannel, LinePlace

_LATE_S = 0.1  # so far behind the plan it is given up: nothing is made up for in a burst


class Counts(NamedTuple):
    """`generated` = `sent` + `refused` + `not_acknowledged`; the last were aborted, by the generator or at bus-off.

    `late_s` is the time by which the plan was delayed because the bus or this machine could not keep up.
    """

    generated: int
    sent: int
    refused: int
    not_acknowledged: int
    seconds: float
    late_s: float

    def __str__(self) -> str:
        rate = f", {self.sent / self.seconds:.1f} frames/s" if self.seconds > 0 else ""
        late = f"; {self.late_s:.2f} s behind the plan, which was moved" if self.late_s >= _LATE_S else ""
        return (
            f"{self.sent} sent, {self.refused} refused, {self.not_acknowledged} not acknowledged in "
            f"{self.seconds:.2f} s{rate}{late}"
        )


class Generator:
    """Sends the frames of a plan: pairs of the seconds since the previous frame, and the frame.

    `seconds` limits the time (None: until the end of the plan); `timeout_s` limits the time without progress.
    """

    def __init__(self, hub: Hub, place: LinePlace, channel: HubChannel, timeout_s: float) -> None:
        self._hub = hub
        self._channel = channel
        self._sending = Sending(hub, place, channel, timeout_s)
        self._generated = 0
        self._late_s = 0.0
        self._began_s = self._now_s()
        self._ended_s: float | None = None

    def run(
        self, plan: Iterable[tuple[float, Frame]], seconds: float | None, *, endless: bool = False
    ) -> int:
        """Send until the plan or the time is over; 1 if frames were not delivered, with the reason on stderr.

        If the line makes no progress, an `endless` plan waits; any other plan is aborted after `timeout_s`.
        """
        due_s = self._began_s = self._now_s()
        end_s = None if seconds is None else self._began_s + seconds
        for gap_s, frame in plan:
            due_s = self._wait_until(due_s + gap_s, end_s, gap_s > 0)
            if end_s is not None and due_s >= end_s:
                break
            self._generated += 1
            if endless:
                if not self._sending.queue_patiently(
                    frame, lambda: end_s is not None and self._now_s() >= end_s
                ):
                    break
            elif not self._sending.queue(frame):
                break
        status = self._sending.result()
        self._ended_s = self._now_s()
        return status

    def counts(self) -> Counts:
        """The counts; frames that still wait are aborted first, so that none is sent later. Raises HubError."""
        ended_s = self._now_s() if self._ended_s is None else self._ended_s
        status = self._sending.give_up()
        missing = self._generated - status.delivered - status.refused
        return Counts(
            self._generated, status.delivered, status.refused, missing, ended_s - self._began_s, self._late_s
        )

    def summary(self) -> str:
        """The counts on a line; only the generated frames if the hub is gone."""
        try:
            return str(self.counts())
        except HubError as error:
            return f"{self._generated} generated, sent unknown: {error}"

    def _wait_until(self, due_s: float, end_s: float | None, planned: bool) -> float:
        """Wait for that moment, or for the end; the moment, later where it had passed long ago.

        Frames without a gap were not `planned` for any moment: they cannot be late.
        """
        until_s = due_s if end_s is None else min(due_s, end_s)
        left_s = until_s - self._now_s()
        if left_s > 0:
            if self._hub.virtual:
                self._hub.run_for(left_s)
            else:
                time.sleep(left_s)
        elif left_s < -_LATE_S:
            self._late_s -= left_s * planned
            return due_s - left_s
        return due_s

    def _now_s(self) -> float:
        return self._hub.now_ns() / 1e9 if self._hub.virtual else time.monotonic()
