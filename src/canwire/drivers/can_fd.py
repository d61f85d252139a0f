"""Driver of the ideal CAN FD controller, which has no registers: settings go straight to its bit times."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Protocol

from canwire.bus.can.node import Mailbox, Sink
from canwire.drivers.driver import Counters, Driver, LineSettings
from canwire.errors import BadTiming, BadValue, Unsupported
from canwire.values.controller_options import ControllerOptions, DelayCompensation
from canwire.values.event import ErrorState
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming

if TYPE_CHECKING:
    from canwire.chips.host import Host

CLASSIC_ONLY, ISO_FD, NON_ISO_FD = range(3)
LARGEST_OFFSET_PPM = 100_000


class Controller(Protocol):
    """The methods of the chip that this driver uses; times in picoseconds."""

    @property
    def normal(self) -> Mailbox: ...
    @property
    def high(self) -> Mailbox: ...
    @property
    def last_error(self) -> int: ...

    bus: Any
    sink: Sink | None
    attentive: bool
    timing: NodeTiming | None

    def configure(
        self,
        nominal: tuple[int, ...],
        data: tuple[int, ...] | None,
        fd: int,
        listen_only: bool,
        options: ControllerOptions,
    ) -> None: ...
    def forget(self) -> None: ...
    def start(self, at_ns: int, *, integrated: bool = False) -> None: ...
    def stop(self, at_ns: int) -> None: ...
    def restart(self, at_ns: int) -> None: ...
    def rejoin(self, at_ns: int) -> None: ...
    def counters(self) -> tuple[int, ...]: ...
    def take(self, box: Mailbox) -> None: ...
    def abort(self, box: Mailbox, at_ns: int) -> bool: ...


class CanFdDriver(Driver):
    """The Driver (drivers/driver.py) of the ideal controller."""

    def __init__(self, host: Host, controller: Controller) -> None:
        super().__init__(host, controller.normal, controller.high)
        self._controller = controller

    def check(self, settings: LineSettings) -> None:
        ppm = settings.oscillator_ppm
        if not -LARGEST_OFFSET_PPM <= ppm <= LARGEST_OFFSET_PPM:
            raise BadTiming(f"oscillator_ppm {ppm}: from -{LARGEST_OFFSET_PPM} to {LARGEST_OFFSET_PPM}")
        if settings.registers:
            raise Unsupported(f"register {settings.registers[0][0]}: the ideal controller has no registers")
        if settings.loop_back:
            raise Unsupported("the ideal controller has no loop-back")
        _options(settings)
        if settings.options.restricted and settings.listen_only:
            raise BadValue("listen_only and restricted: one acknowledges, the other does not; choose one")

    def configure(self, settings: LineSettings) -> None:
        self.check(settings)
        ppm, data = settings.oscillator_ppm, settings.data_timing
        fd = CLASSIC_ONLY if data is None else ISO_FD if settings.iso_fd else NON_ISO_FD
        self._controller.configure(
            bit_times(settings.timing, ppm),
            None if data is None else bit_times(data, ppm),
            fd,
            settings.listen_only,
            _options(settings),
        )
        self._controller.timing = NodeTiming(
            "controller", settings.timing, data, ppm, options=settings.options
        )
        self.listen_only, self.fd = settings.listen_only or settings.options.restricted, fd

    def forget(self) -> None:
        super().forget()
        self._controller.forget()

    def start(self, at_ns: int, integrated: bool = False) -> None:
        self.running = True
        self._controller.start(at_ns, integrated=integrated)

    def stop(self, at_ns: int) -> None:
        self.running = False
        self._controller.stop(at_ns)

    def restart(self, at_ns: int) -> None:
        self._controller.restart(at_ns)

    def rejoin(self, at_ns: int) -> None:
        self._controller.rejoin(at_ns)

    def on_wire(self) -> bool:
        bus = self._controller.bus
        return bus is not None and bool(bus.on_wire(self._controller))

    def counters(self) -> Counters:
        tec, rec, state, errors, losses, sent, received = self._controller.counters()
        last_error = int(self._controller.last_error)
        return Counters(tec, rec, ErrorState(state), errors, losses, sent, received, last_error)

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        self._controller.take(box)

    def poll(self) -> None:
        bus = self._controller.bus
        if bus is not None:
            bus.poll(self._controller)

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        return bool(self._controller.abort(box, at_ns))

    def listen(self, sink: Sink, attentive: bool) -> None:
        self._controller.sink = sink
        if attentive and not self._controller.attentive and self._controller.bus is not None:
            self._controller.bus.interrupt()  # the frame on the wire was not meant to be noticed
        self._controller.attentive = attentive


def _options(settings: LineSettings) -> ControllerOptions:
    """The requested options; the tdo of a timing is also an offset of the delay compensation."""
    options, data = settings.options, settings.data_timing
    if options.compensation is None and data is not None and data.tdo:
        return replace(options, compensation=DelayCompensation(1e9 * data.tdo / data.clock_hz))
    return options


def bit_times(timing: BitTiming, ppm: float) -> tuple[int, int, int, int, int]:
    """Bit, sample point, quantum, PHASE1 and synchronisation jump in ps, with an oscillator that is off by `ppm`."""
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
