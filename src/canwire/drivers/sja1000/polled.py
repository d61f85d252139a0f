"""A real SJA1000 behind I/O ports of this machine: its registers are polled, since no interrupt is available."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.drivers.driver import Counters
from canwire.drivers.sja1000.driver import Sja1000Driver
from canwire.drivers.sja1000.port_access import PATH, PortAccess
from canwire.errors import NoSuchBoard
from canwire.timeline import Timeline, Timer
from canwire.values.isa_address import port_text

if TYPE_CHECKING:
    from canwire.chips.host import Host

PERIOD_NS = 400_000  # five frames of 8 bytes fit the chip's FIFO: 550 us at 1 Mbit/s


class PortDriver(Sja1000Driver):
    """Sja1000Driver that serves its chip every PERIOD_NS of the timeline while it runs."""

    def __init__(self, host: Host | None, ports: PortAccess, timeline: Timeline) -> None:
        super().__init__(host, ports, lambda: timeline.now_ns)
        self._ports = ports
        self._timeline = timeline
        self._timer: Timer | None = None
        self._last: Counters | None = None

    def start(self, at_ns: int, integrated: bool = False) -> None:
        super().start(at_ns, integrated)
        self._look_again()

    def stop(self, at_ns: int) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._last is None:
            super().stop(at_ns)

    def close(self) -> None:
        if self._last is None:
            super().close()
            self._last = self.counters()
            self._ports.close()

    def counters(self) -> Counters:
        """The present counters; after `close`, the last ones."""
        return super().counters() if self._last is None else self._last

    def _look(self) -> None:
        self.service()
        if self.running:
            self._look_again()

    def _look_again(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
        at_ns = self._timeline.now_ns + PERIOD_NS
        self._timer = self._timeline.at(at_ns, self._look, background=True)


def port_driver(host: Host | None, base: int, timeline: Timeline, path: str = PATH) -> PortDriver:
    """The driver of the board at this address; raises NoSuchBoard if no chip answers, and what PortAccess raises."""
    ports = PortAccess(base, path)
    if not ports.answers():
        ports.close()
        raise NoSuchBoard(
            f"no SJA1000 answers at {port_text(base)} of {path}; compare the board's jumpers E20..E24"
        )
    return PortDriver(host, ports, timeline)
