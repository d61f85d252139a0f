"""Temperature sensors, cooling fans and a controller on one CAN bus: the example of the CANDRV manual.

    sensor -> controller   ID 0x100: sensor number, temperature             once a second
    controller -> fan      ID 0x200: fan number, 0 off / 1 on               when required
    fan -> controller      ID 0x300 + fan number: 0 off / 1 on              every two seconds, and on a change

The third line is ours (in the manual fans never send): a node that never sends cannot go bus-off.
`CodedIds` is the manual's second proposal, where number and value are part of the identifier.

Source: CANDRV manual chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from canwire import Acceptance, BusEvent, ErrorState, EventKind, Frame, NodeScript

STATUS = 0x300
TOO_HOT, COOL = 80, 60  # degrees at which the controller switches a fan on and off
_ID_BITS = 0x7FF
_REPORT_S = 1.0
_STATUS_S = 2.0
_SILENCE_NS = 5_000_000_000

Tell = Callable[[str], None]


class Coding(Protocol):
    """How temperatures and switching commands are coded as frames, and which node accepts them."""

    def temperature(self, sensor: int, degrees: int) -> Frame: ...

    def switch(self, fan: int, on: bool) -> Frame: ...

    def read_temperature(self, frame: Frame) -> tuple[int, int] | None:
        """Sensor and degrees, or None for another frame."""

    def read_switch(self, frame: Frame) -> tuple[int, bool] | None:
        """Fan and on, or None for another frame."""

    def temperatures(self) -> Acceptance:
        """Return the filter that accepts the messages of every sensor and nothing else."""

    def switches(self, fan: int) -> Acceptance:
        """Return the filter that accepts the commands for one fan and nothing else."""


class PlainIds:
    """One identifier for each kind of message; numbers and values are data."""

    _TEMPERATURE, _SWITCH = 0x100, 0x200

    def temperature(self, sensor: int, degrees: int) -> Frame:
        return Frame(self._TEMPERATURE, bytes([sensor, degrees]))

    def switch(self, fan: int, on: bool) -> Frame:
        return Frame(self._SWITCH, bytes([fan, on]))

    def read_temperature(self, frame: Frame) -> tuple[int, int] | None:
        return (frame.data[0], frame.data[1]) if frame.id == self._TEMPERATURE else None

    def read_switch(self, frame: Frame) -> tuple[int, bool] | None:
        return (frame.data[0], bool(frame.data[1])) if frame.id == self._SWITCH else None

    def temperatures(self) -> Acceptance:
        return Acceptance.from_filters([(self._TEMPERATURE, _ID_BITS)])

    def switches(self, fan: int) -> Acceptance:
        ((code, mask),) = Acceptance.from_filters([(self._SWITCH, _ID_BITS)]).pairs
        return Acceptance(((code | fan << 8, mask | 0xFF << 8),))  # bits 15..8: the first data byte


class CodedIds:
    """1 nn tttttttt: sensor n reports t; 011 11111 nn s: switch fan n to s. No data at all.

    Masks stand here as in the manual (1 accepts anything) and are turned over for our filters.
    """

    _SENSOR, _SENSOR_MASK = 0b100_00000000, 0b011_11111111
    _FAN, _FAN_MASK = 0b011_11111_000, 0b000_00000_001

    def temperature(self, sensor: int, degrees: int) -> Frame:
        return Frame(self._SENSOR | sensor << 8 | degrees)

    def switch(self, fan: int, on: bool) -> Frame:
        return Frame(self._FAN | fan << 1 | on)

    def read_temperature(self, frame: Frame) -> tuple[int, int] | None:
        return (frame.id >> 8 & 3, frame.id & 0xFF) if frame.id & self._SENSOR else None

    def read_switch(self, frame: Frame) -> tuple[int, bool] | None:
        return (frame.id >> 1 & 3, bool(frame.id & 1)) if frame.id >> 3 == self._FAN >> 3 else None

    def temperatures(self) -> Acceptance:
        return Acceptance.from_filters([(self._SENSOR, ~self._SENSOR_MASK & _ID_BITS)])

    def switches(self, fan: int) -> Acceptance:
        return Acceptance.from_filters([(self._FAN | fan << 1, ~self._FAN_MASK & _ID_BITS)])


class Machine:
    """Two hot places, each with a fan. In thousandths of a degree and whole nanoseconds: no rounding drifts.

    A place warms by `heating` a second, and cools by `cooling` less that while its fan turns.
    """

    def __init__(self) -> None:
        self._milli = {1: 70_000, 2: 58_000}
        self._heating = {1: 3_100, 2: 2_300}
        self._cooling = {1: 7_400, 2: 6_700}
        self._turning = {1: False, 2: False}
        self._since_ns = {1: 0, 2: 0}

    def degrees(self, place: int, now_ns: int) -> int:
        """Temperature now, whole degrees, 20..255."""
        rate = self._heating[place] - (self._cooling[place] if self._turning[place] else 0)
        passed_ns, self._since_ns[place] = now_ns - self._since_ns[place], now_ns
        warmer = self._milli[place] + rate * passed_ns // 1_000_000_000
        self._milli[place] = min(max(warmer, 20_000), 255_000)
        return self._milli[place] // 1000

    def turn(self, place: int, on: bool, now_ns: int) -> None:
        """Switch the fan of a place."""
        self.degrees(place, now_ns)
        self._turning[place] = on


class Sensor(NodeScript):
    """Reports its temperature every second; reacts to nothing."""

    def __init__(self, machine: Machine, coding: Coding, number: int) -> None:
        self._machine, self._coding, self._number = machine, coding, number

    def on_start(self) -> None:
        # a tenth of a second later for each: real devices are not switched on in the same nanosecond
        self.after(0.1 * self._number, self._begin)

    def _begin(self) -> None:
        self._report()
        self.every(_REPORT_S, self._report)

    def _report(self) -> None:
        self.send(self._coding.temperature(self._number, self._machine.degrees(self._number, self.now_ns)))


class Fan(NodeScript):
    """Turns on command and reports whether it turns; prints each change of its controller's state."""

    def __init__(self, machine: Machine, coding: Coding, number: int, tell: Tell) -> None:
        self._machine, self._coding, self._number, self._tell = machine, coding, number, tell
        self._on = False

    def on_start(self) -> None:
        self.every(_STATUS_S, self._report)

    def on_message(self, frame: Frame) -> None:
        command = self._coding.read_switch(frame)
        if command is not None and command[1] != self._on:
            self._on = command[1]
            self._machine.turn(self._number, self._on, self.now_ns)
            self._report()

    def on_event(self, event: BusEvent) -> None:
        if event.kind is EventKind.STATE:
            self._tell(f"fan {self._number} is {event.state.name}, TEC {event.tec}, REC {event.rec}")
            if event.state is ErrorState.BUS_OFF:
                self._machine.turn(self._number, False, self.now_ns)
                self._on = False
                self.node.cancel()

    def _report(self) -> None:
        if self.node.state is not ErrorState.BUS_OFF:
            self.send(Frame(STATUS + self._number, bytes([self._on])))


class Controller(NodeScript):
    """Switches each fan on above TOO_HOT and off below COOL, until the fan says that it has done so."""

    def __init__(self, coding: Coding, fans: tuple[int, ...], tell: Tell) -> None:
        self._coding, self._tell = coding, tell
        self._turning = dict.fromkeys(fans, False)
        self._heard_ns = dict.fromkeys(fans, 0)
        self._missing: set[int] = set()

    def on_message(self, frame: Frame) -> None:
        reading = self._coding.read_temperature(frame)
        if reading is not None:
            self._regulate(*reading)
        elif frame.id - STATUS in self._turning:
            self._hear(frame.id - STATUS, bool(frame.data[0]))

    def _regulate(self, place: int, degrees: int) -> None:
        turning = self._turning[place]
        wanted = degrees >= TOO_HOT or (turning and degrees > COOL)
        if wanted != turning:
            self.send(self._coding.switch(place, wanted))
        if self.now_ns - self._heard_ns[place] > _SILENCE_NS and place not in self._missing:
            self._missing.add(place)
            self._turning[place] = False
            self._tell(f"controller: fan {place} is silent")

    def _hear(self, fan: int, turning: bool) -> None:
        self._turning[fan] = turning
        self._heard_ns[fan] = self.now_ns
        if fan in self._missing:
            self._missing.discard(fan)
            self._tell(f"controller: fan {fan} is back")
