"""Driver of the ideal CAN FD controller, which has no registers: settings go straight to its bit times."""

from __future__ import annotations

from typing import Protocol

from canwire.drivers.driver import Counters, LineSettings
from canwire.errors import BadTiming
from canwire.values.bit_timing import BitTiming
from canwire.values.event import ErrorState

CLASSIC_ONLY, ISO_FD, NON_ISO_FD = range(3)
LARGEST_OFFSET_PPM = 100_000


class Controller(Protocol):
    """What this driver needs of the chip; times in picoseconds."""

    def configure(
        self, nominal: tuple[int, ...], data: tuple[int, ...] | None, fd: int, listen_only: bool
    ) -> None: ...
    def start(self, at_ns: int, *, integrated: bool = False) -> None: ...
    def stop(self, at_ns: int) -> None: ...
    def restart(self, at_ns: int) -> None: ...
    def counters(self) -> tuple[int, ...]: ...


class CanFdDriver:
    """drivers/driver.py's seam over the ideal controller."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller

    def configure(self, settings: LineSettings) -> None:
        ppm = settings.oscillator_ppm
        if not -LARGEST_OFFSET_PPM <= ppm <= LARGEST_OFFSET_PPM:
            raise BadTiming(f"oscillator_ppm {ppm}: from -{LARGEST_OFFSET_PPM} to {LARGEST_OFFSET_PPM}")
        data = settings.data_timing
        self._controller.configure(
            bit_times(settings.timing, ppm),
            None if data is None else bit_times(data, ppm),
            CLASSIC_ONLY if data is None else ISO_FD if settings.iso_fd else NON_ISO_FD,
            settings.listen_only,
        )

    def start(self, at_ns: int, *, integrated: bool = False) -> None:
        self._controller.start(at_ns, integrated=integrated)

    def stop(self, at_ns: int) -> None:
        self._controller.stop(at_ns)

    def restart(self, at_ns: int) -> None:
        self._controller.restart(at_ns)

    def counters(self) -> Counters:
        tec, rec, state, errors, losses, sent, received = self._controller.counters()
        return Counters(tec, rec, ErrorState(state), errors, losses, sent, received)

    def close(self) -> None:
        self._controller.stop(0)


def bit_times(timing: BitTiming, ppm: float) -> tuple[int, int, int, int, int]:
    """Bit, sample point, quantum, PHASE1 and synchronisation jump in ps, by an oscillator off by `ppm`."""
    scale = 1.0 / (1.0 + ppm * 1e-6)
    quantum = timing.quantum_ps
    exact = (
        timing.bit_time_ps,
        timing.sample_time_ps,
        quantum,
        timing.phase1 * quantum,
        timing.jump * quantum,
    )
    bit, sample, quantum, phase1, jump = (round(value * scale) for value in exact)
    return bit, sample, quantum, phase1, jump
