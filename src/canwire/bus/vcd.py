"""The level on a bus as a Value Change Dump, the form that sigrok, PulseView and GTKWave read.

Source: IEEE 1364-2005 chapter 18.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bus import LinBus

if TYPE_CHECKING:
    from _typeshed import SupportsWrite


_CHANGES = ("#%d\n0!\n", "#%d\n1!\n")  # by level


class VcdTrace:
    """Writes every change of one bus's level, in nanoseconds, to a text file that the caller owns.

    While it runs the bus goes bit by bit, which is slower but changes no time. `close` ends the trace.
    """

    def __init__(self, bus: CanBus | LinBus, file: SupportsWrite[str], signal: str) -> None:
        self._bus = bus
        self._file = file
        self._last_ns = -1
        file.write("$comment 1 is recessive, 0 is dominant $end\n$timescale 1 ns $end\n")
        file.write(f"$scope module canwire $end\n$var wire 1 ! {signal} $end\n$upscope $end\n")
        file.write(f"$enddefinitions $end\n#{bus.timeline.now_ns}\n1!\n")
        bus.interrupt()
        bus.bits.capture = self._change
        if isinstance(bus, CanBus):
            bus.bits.capture_many = self._change_often
        bus.bitwise = True

    def close(self) -> None:
        """Write the end of the trace and let the bus run at full speed again."""
        if self.leave():
            self._file.write(f"#{self._bus.timeline.now_ns}\n")

    def leave(self) -> bool:
        """Let the bus run at full speed again, and write nothing; False if the trace has ended before."""
        if self._bus.bits.capture != self._change:
            return False
        self._bus.bits.capture = None
        if isinstance(self._bus, CanBus):
            self._bus.bits.capture_many = None
        self._bus.bitwise = False
        return True

    def _change(self, time_ps: int, level: int) -> None:
        self._file.write(f"#{time_ps // 1000}\n{level}!\n")

    def _change_often(self, times_ns: list[int], level: int) -> None:
        """Write all changes of a stretch together; the level is the one after the first of them."""
        pairs, odd = divmod(len(times_ns), 2)
        text = (_CHANGES[level] + _CHANGES[1 - level]) * pairs + _CHANGES[level] * odd
        self._file.write(text % tuple(times_ns))
