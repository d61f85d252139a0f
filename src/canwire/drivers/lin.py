"""Driver of the ideal LIN controller, which has no registers: settings go straight to its bit times."""

from __future__ import annotations

from typing import Any, Protocol

from canwire.drivers.lin_driver import LinCounters, LinSettings
from canwire.errors import BadTiming
from canwire.values.lin.event import LinState
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.timing import (
    AUTO_RATE,
    LOWEST_RATE,
    bit_rate_of,
    bit_time_ps,
    checked_rate,
)

LARGEST_OFFSET_PPM = 200_000
_RANGES = {
    "break_bits": (13, 60),
    "delimiter_bits": (1, 14),
    "header_space_bits": (0, 14),
    "response_space_bits": (0, 126),
    "byte_space_bits": (0, 126),
    "start_up_ns": (0, 100_000_000),
    "oscillator_ppm": (-LARGEST_OFFSET_PPM, LARGEST_OFFSET_PPM),
}


class Table(Protocol):
    """The methods of the chip's response table that this driver uses."""

    @property
    def updated(self) -> set[int]: ...
    @property
    def response_error(self) -> bool: ...
    def put(self, id: int, data: bytes, enhanced: bool, once: bool) -> None: ...
    def remove(self, id: int) -> None: ...
    def associate(self, event: int, id: int) -> None: ...
    def put_status_bit(self, id: int, bit: int) -> None: ...
    def take(self, id: int) -> Any: ...
    def place(self, id: int, role: Any) -> None: ...


class Controller(Protocol):
    """The methods of the chip that this driver uses; times in picoseconds."""

    bus: Any
    searching: bool
    bit_ps: int
    headers: int
    frames_sent: int
    frames_received: int
    wake_ups: int
    errors: list[int]
    lengths: list[int]
    models: list[bool | None]

    @property
    def table(self) -> Table: ...
    def configure(
        self,
        bit_ps: int,
        *,
        synchronises: bool,
        searching: bool,
        header: tuple[int, int, int],
        response_spaces: tuple[int, int],
        start_up_ns: int,
    ) -> None: ...
    def start(self, at_ns: int) -> None: ...
    def stop(self, at_ns: int) -> None: ...
    def clear(self) -> None: ...
    def subscribe(self, id: int, length: int) -> None: ...
    def ask(self, id: int, length: int, silence_is_fine: bool) -> None: ...
    def send(self, id: int, data: bytes, enhanced: bool) -> None: ...
    def wake_up(self) -> None: ...
    def state(self, at_ns: int) -> LinState: ...
    def status(self) -> int: ...


class LinControllerDriver:
    """The LinDriver (drivers/lin_driver.py) of the ideal controller."""

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._bit_rate = AUTO_RATE

    def configure(self, settings: LinSettings) -> None:
        for name, (least, most) in _RANGES.items():
            value = getattr(settings, name)
            if not least <= value <= most:
                raise BadTiming(f"{name} {value!r}: from {least} to {most}")
        self._bit_rate = checked_rate(settings.bit_rate, auto=not settings.master)
        searching = settings.bit_rate == AUTO_RATE
        self._controller.configure(
            bit_time_ps(settings.bit_rate or LOWEST_RATE, settings.oscillator_ppm),
            synchronises=searching or (settings.synchronises and not settings.master),
            searching=searching,
            header=(settings.break_bits, settings.delimiter_bits, settings.header_space_bits),
            response_spaces=(settings.response_space_bits, settings.byte_space_bits),
            start_up_ns=settings.start_up_ns,
        )

    def start(self, at_ns: int) -> None:
        self._controller.start(at_ns)

    def stop(self, at_ns: int) -> None:
        self._controller.stop(at_ns)

    def clear(self) -> None:
        self._controller.clear()

    def respond(self, frame: LinFrame, *, once: bool = False) -> None:
        self._controller.table.put(frame.id, frame.data, frame.enhanced, once)

    def withdraw(self, id: int) -> None:
        self._controller.table.remove(id)

    def subscribe(self, id: int, length: int) -> None:
        self._controller.subscribe(id, length)

    def expect_checksum(self, id: int, enhanced: bool | None) -> None:
        self._controller.models[id] = enhanced

    def associate(self, event: int, id: int) -> None:
        self._controller.table.associate(event, id)

    def take(self, id: int) -> object:
        controller = self._controller
        role = (controller.table.take(id), controller.lengths[id], controller.models[id])
        controller.subscribe(id, 0)
        controller.models[id] = None
        return role

    def place(self, id: int, role: Any) -> None:
        row, length, model = role
        self._controller.table.place(id, row)
        self._controller.subscribe(id, length)
        self._controller.models[id] = model

    def report_errors_in(self, id: int, bit: int) -> None:
        self._controller.table.put_status_bit(id, bit)

    def is_updated(self, id: int) -> bool:
        return id in self._controller.table.updated

    def ask(self, id: int, length: int, silence_is_fine: bool) -> None:
        self._controller.ask(id, length, silence_is_fine)

    def send(self, frame: LinFrame) -> None:
        self._controller.send(frame.id, frame.data, frame.enhanced)

    def wake_up(self) -> None:
        self._controller.wake_up()

    def on_wire(self) -> bool:
        controller = self._controller
        return controller.bus is not None and bool(controller.bus.on_wire(controller))

    def counters(self, at_ns: int) -> LinCounters:
        controller = self._controller
        bit_rate = self._bit_rate
        if bit_rate == AUTO_RATE and not controller.searching:
            bit_rate = bit_rate_of(controller.bit_ps)
        return LinCounters(
            state=controller.state(at_ns),
            status=controller.status(),
            bit_rate=bit_rate,
            headers=controller.headers,
            frames_sent=controller.frames_sent,
            frames_received=controller.frames_received,
            wake_ups=controller.wake_ups,
            errors=tuple(controller.errors),
            response_error=controller.table.response_error,
        )

    def close(self) -> None:
        self._controller.stop(0)
