"""A node that babbles: it sends one frame repeatedly, whatever other nodes send."""

from __future__ import annotations

from canwire.boards.can.channel import Channel
from canwire.boards.catalogue import ideal_line, plug, unplug
from canwire.bus.can.bus import CanBus
from canwire.bus.scripted import Scripted
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline
from canwire.values.frame import Frame
from canwire.values.record import CONFIRM

_AHEAD = 2  # frames queued, so that one follows the other immediately


class Babbler:
    """A node with a separate controller, which takes part in the bus as usual: it acknowledges, and may go bus-off.

    `babbling` counts the frames that it has sent successfully, and ends it.
    """

    def __init__(
        self,
        bus: CanBus,
        timeline: Timeline,
        settings: LineSettings,
        frame: Frame,
        gap_ns: int,
        times: int | None,
    ) -> None:
        self.babbling = Scripted(times=times, remove=self._stop)
        self._timeline = timeline
        self._frame = frame
        self._gap_ns = gap_ns
        self._queued = 0
        self._begun = False
        self._line = ideal_line("babbling node", timeline)
        self._line.controller.name = "babbling node"
        self._channel = self._line.open(Channel(1, _AHEAD, frames=False))
        self._line.driver.configure(settings)
        plug(self._line, bus)
        self._line.driver.start(timeline.now_ns, integrated=bus.resting())
        for _ in range(_AHEAD):
            self._send()

    def _send(self) -> None:
        left = self.babbling.times_left
        if not self.babbling.cancelled and (left is None or self._queued < left):
            self._queued += 1
            self._line.send(self._channel, self._frame, CONFIRM, self._gap_ns if self._begun else 0)
            self._begun = True
            self._channel.expect_outcome(False, self._settled)

    def _settled(self, delivered: bool, at_ns: int) -> None:
        self._queued -= 1
        last = delivered and self.babbling.times_left == 1
        self._timeline.at(at_ns, self.babbling.cancel if last else self._send)  # gone before that is reported
        if delivered:
            self.babbling.strike()

    def _stop(self, babbling: Scripted) -> None:
        self._line.driver.stop(self._timeline.now_ns)
        unplug(self._line)
        self._line.close(self._channel)
