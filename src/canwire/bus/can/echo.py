# cython: nonecheck=False
"""The levels that one node drives, as they arrive later; and the second sample points of a sender's own bits.

With transmitter delay compensation a sender measures in the res bit how late its own edge comes back. A bit of the
data phase is then sampled that long, plus an offset, after its start; one that was wrong is an error at the next
ordinary sample point.

Source: ISO 11898-1:2015 chapter 11.3.3; Bosch M_CAN user's manual, transmitter delay compensation.
"""

from __future__ import annotations

from canwire import _mem
from canwire.bus.can.node import NOBODY, Node
from canwire.timeline import NEVER
from canwire.values.checks import instance

_NEVER = NEVER
_HISTORY = 64


class Echo:
    """The changes of one node's level; times are bit_level.py's picoseconds.

    `measuring_ps` is when its res bit began, until that edge has come back, `measured_ps` how long that took.
    """

    def __cinit__(self, *_: object) -> None:
        """Compiled: nothing that C reads is None, not even in what was never initialised."""
        self.node = NOBODY
        self._take_memory()

    def __init__(self, node: Node) -> None:
        instance("node", node, Node)
        self.node = node
        self._take_memory()
        self.begin()

    def _take_memory(self) -> None:
        self._block = bytearray(8 * _HISTORY)
        self._history = _mem.words_of(self._block)  # of each change, its time and then one bit, the new level
        self._checks: list[int] = []
        self._expected: list[int] = []

    def begin(self) -> None:
        """Forget all earlier changes."""
        self.changes = 0
        self.last = 1
        self.measuring_ps = _NEVER
        self.measured_ps = 0
        self.failed = False
        if self._checks:
            self.forget_checks()

    def drive(self, level: int, at_ps: int) -> None:
        """Record that the node drives this level from now on."""
        if level == self.last:
            return
        self._history[self.changes % _HISTORY] = at_ps << 1 | level
        self.last = level
        self.changes += 1

    def drive_run(self, levels: bytes, first: int, bits: int, at_ps: int, bit_ps: int) -> None:
        """Record that the node drives these levels in bits of `bit_ps`, the first of which begins at `at_ps`."""
        last, changes = self.last, self.changes
        for k in range(first, first + bits):
            if levels[k] != last:
                last = levels[k]
                self._history[changes % _HISTORY] = (at_ps + (k - first) * bit_ps) << 1 | last
                changes += 1
        self.last, self.changes = last, changes

    def changed_at(self, at_ps: int) -> bool:
        """Whether its last change was at this time."""
        if self.changes == 0:
            return False
        changed_ps = self._history[(self.changes - 1) % _HISTORY] >> 1
        return changed_ps == at_ps

    def level_at(self, at_ps: int) -> int:
        """The level that the node drove at an earlier time."""
        newest = self.changes
        oldest = newest - _HISTORY if newest > _HISTORY else 0
        while newest > oldest:
            newest -= 1
            changed_ps = self._history[newest % _HISTORY] >> 1
            if changed_ps <= at_ps:
                return self._history[newest % _HISTORY] & 1
        return 1

    def takes(self, at_ps: int) -> bool:
        """True if the arriving edge sets no clock: it is measured, or hidden by the node's own dominant level."""
        if self._measured(at_ps):
            return True
        return self.node.loop_ps > 0 and self.level_at(at_ps - self.node.loop_ps) == 0

    def measure_from(self, at_ps: int) -> int:
        """Start to measure the delay as the res bit begins; returns when its edge will be back."""
        self.measuring_ps = at_ps
        self.measured_ps = 0
        return at_ps + self.node.loop_ps

    def _measured(self, at_ps: int) -> bool:
        """Measure the delay of an edge that came during the res bit, unless it is shorter than the filter allows."""
        if self.measuring_ps == _NEVER:
            return False
        delay_ps = at_ps - self.measuring_ps
        if delay_ps >= self.node.bit_ps:
            self.measuring_ps = _NEVER
            return False
        if delay_ps + self.node.second_sample_ps >= self.node.least_second_ps:
            self.measured_ps = delay_ps
            self.measuring_ps = _NEVER
        return True

    def look_later(self, level: int, at_ps: int) -> int:
        """Note the second sample point of a data phase bit that begins; returns the time of the next such check."""
        node = self.node
        after_ps = node.second_sample_ps
        if node.measures_delay:
            after_ps += self.measured_ps
            if after_ps < node.least_second_ps:
                after_ps = node.least_second_ps
        self._checks.append(at_ps + after_ps)
        self._expected.append(level)
        return self._checks[0]

    def invert(self) -> None:
        """Note that the node will read the bit that has just begun wrong."""
        if self._expected:
            self._expected.append(self._expected.pop() ^ 1)

    def check(self, level: int) -> int:
        """Check the oldest bit at its second sample point; returns the time of the next check, or NEVER."""
        if self._checks:
            self._checks.pop(0)
            if self._expected.pop(0) != level:
                self.failed = True
        return self._checks[0] if self._checks else _NEVER

    def outcome(self, level: int) -> int:
        """The level that an ordinary sample point returns: the opposite if a second one has found an error."""
        failed = self.failed
        self.failed = False
        return level ^ 1 if failed else level

    def forget_checks(self) -> int:
        """Cancel the second sample points at the end of the data phase; returns NEVER."""
        self._checks.clear()
        self._expected.clear()
        self.failed = False
        return _NEVER
