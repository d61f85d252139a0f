"""A device such as CID1: the line that it drives, the line's configuration, and the state that all programs share.

A driver is loaded once: the program that opens its device first stores the registry's entries at the hub (note
"candrv/CID1:") and configures the line with them, unless a program of another dialect has configured it. Both stay
until `unload`: so new entries take effect when the driver is loaded the next time, as the manual says, and a rate that
one program sets remains for the next. The rate, listen-only and loop-back are part of the line's mode; the CAN mode and
the default frame format are in the note of that mode; "virtualize" is in a separate note of the hub.

Source: CANDRV manual, chapter 6, 8.1, 8.13 to 8.18, 8.23; rulings.md 17.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, TypeVar

from canwire import CanwireError, ErrorState, Feature, FilterMode, FilterSetup, InUse, LineMode, LineStatus
from canwire.candrv.constants import CanMode, FrameFormat
from canwire.candrv.device.bell import Bell
from canwire.candrv.device.state import KIN, DeviceState, can_time, checked, state_of
from canwire.candrv.errors import translated
from canwire.candrv.registry.loading import (
    controller_on,
    find_port,
    loaded,
    settings_note,
    usual_store,
)

if TYPE_CHECKING:
    from canwire import Control, Hub, LineInfo
    from canwire.candrv.registry.registry import RegistryStore

T = TypeVar("T")

_PAUSES_S = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8)  # 1.6 s, for a busy machine
_OPEN = FilterSetup(FilterMode.PASS, 0)  # each receive channel has its own filter
_CONFIGURATION = 4  # the MCP2515's OPMOD


class Device:
    """A device of the registry on a hub: its line, and the state that all its handles share.

    `name` is the name for CreateFile, "CID1:". Raises NoSuchBoard if the name is not registered or its board is
    missing, InUse if another device uses its SPI port.
    """

    def __init__(self, hub: Hub, name: str, store: RegistryStore | None = None) -> None:
        self.hub = hub
        self.name = name.upper()  # Windows ignores the case of such names
        self.settings = loaded(hub, self.name, store or usual_store())
        self.board, self.number = find_port(hub.boards(), self.settings)
        self.controller = controller_on(self.board, self.line)
        self._bell: Bell | None = None  # rung when "virtualize" changes
        self._heard = -1
        self._virtual = False

    @property
    def line(self) -> LineInfo:
        return self.board.lines[self.number]

    def debug(self, text: str) -> None:
        """Print a line on the debug channel, which is stderr, if the registry entry Debug is not 0."""
        if self.settings.debug:
            print(f"{self.name} {text}", file=sys.stderr, flush=True)

    # the line

    def status(self) -> LineStatus:
        return self.hub.line_status(self.board.id, self.number, kin=KIN)

    def state(self) -> DeviceState:
        """The present state; a line that a program of another dialect has configured is in CAN2.0B."""
        return state_of(self.status(), self.settings)

    def start(self) -> None:
        """Configure the line from the registry if it is not configured, and start it on its bus if it is stopped.

        A configured line whose control another program holds stays as it is.
        """
        status = self.status()
        if not status.initialised:
            self.virtualize = bool(self.settings.virtualize)
            self._held(self._start)
        elif not status.running and not status.control_holder:
            self._held(self._start)
        self._join()

    def close(self) -> None:
        """Release what a handle uses of the device; a second call does nothing."""
        bell, self._bell = self._bell, None
        if bell is not None:
            with suppress(CanwireError):
                bell.close()

    def change(
        self,
        *,
        rate: int | None = None,
        mode: int | None = None,
        format: int | None = None,
        listen: bool | None = None,
        loop_back: bool = False,
    ) -> None:
        """Configure the line again, for all programs; None keeps a value. A new format does not touch the controller.

        Loop-back stays through a new rate, mode or format, and ends with `change()` and with listen-only. Raises
        CandrvError and then changes nothing: ERROR_INVALID_PARAMETER for invalid values, ERROR_SHARING_VIOLATION
        while another program holds the control or, for another rate, programs of another dialect run the line.
        """
        wanted = _given(rate=rate, mode=mode, format=format, listen=listen)
        with translated(opened=True):
            if mode is not None:
                checked("CAN mode", mode, CanMode)
            if format is not None:
                checked("frame format", format, FrameFormat)
            if wanted.keys() == {"format"} and not loop_back:
                self._held(lambda control: self._annotate(control, wanted))
            else:
                loop_back = loop_back or (bool(wanted) and listen is None and self.state().loop_back)
                self._held(lambda control: self._configure(control, wanted, loop_back))
        self.debug(f"set up: {self.state()}")

    def initialise(self) -> None:
        """IOCTL_CAN_INIT; after a bus-off it also works while another program holds the control of the line."""
        status = self.status()
        if status.running and status.state == ErrorState.BUS_OFF and status.control_holder:
            self.hub.recover(self.board.id, self.number)
        else:
            self.change()

    def sleep(self, asleep: bool) -> None:
        """ENTER_STANDBY and LEAVE_STANDBY."""
        with translated(opened=True):
            self._held(lambda control: control.sleep() if asleep else control.wake())

    @property
    def virtualize(self) -> bool:
        """Whether handles on this board receive what other handles on it send."""
        if self._bell is not None and (count := self._bell.count) == self._heard:
            return self._virtual
        self._virtual = self.hub.note(self._note("virtualize")) == b"1"
        if self._bell is not None:
            self._heard = count
        return self._virtual

    @virtualize.setter
    def virtualize(self, on: bool) -> None:
        self.hub.set_note(self._note("virtualize"), b"1" if on else b"")
        bell = Bell.find(self.hub, self._note("bell"))
        if bell is not None:
            bell.ring()
            bell.close()

    def read_register(self, address: int, *, reset_mode: bool) -> int:
        with translated(opened=True):
            return self._held(lambda control: control.read_register(address, reset_mode=reset_mode))

    def write_register(self, address: int, value: int, *, reset_mode: bool) -> None:
        with translated(opened=True):
            self._held(lambda control: control.write_register(address, value, reset_mode=reset_mode))

    def clear_overrun(self) -> None:
        """Clear the overrun bits of the chip, if it has such a register; the driver also does so at each overrun."""
        names = {register.name for register in self.hub.registers(self.board.id, self.number)}
        if "CMR" in names or "SR" in names:
            self.write_register(1, 0x08, reset_mode=False)  # SJA1000's CMR: CDO
        elif "EFLG" in names:
            self.write_register(0x2D, 0, reset_mode=False)  # MCP2515's EFLG: RX0OVR and RX1OVR can be cleared

    def in_configuration_mode(self) -> bool:
        """Whether the controller is in its configuration mode (SJA1000: reset mode)."""
        values = {
            register.name: register.value for register in self.hub.registers(self.board.id, self.number)
        }
        if "MOD" in values:
            return bool(values["MOD"] & 1)
        if "CANSTAT" in values:
            return values["CANSTAT"] >> 5 == _CONFIGURATION
        return not self.status().running

    def time_ms(self) -> int:
        """CAN_TIME: milliseconds since the hub was started, in 32 bits."""
        return can_time(self.hub.now_ns())

    def sends(self) -> bool:
        """Whether the line can send: it is running, not listen-only, and not in bus-off."""
        status = self.status()
        listens = status.mode is not None and status.mode.listen_only
        return status.running and not listens and status.state != ErrorState.BUS_OFF

    # its own

    def _note(self, what: str) -> str:
        return f"candrv/{self.name}/{what}"

    def is_open(self) -> bool:
        """Whether a handle of any access shares the bell; one opened while a program held the control does not."""
        bell = Bell.find(self.hub, self._note("bell"))
        if bell is not None:
            bell.close()
        return bell is not None

    def _join(self) -> None:
        """Share a bell with the other handles; while a program holds the control, ask the hub each time instead."""
        self._bell = Bell.find(self.hub, self._note("bell"))
        if self._bell is None and not self.status().control_holder:
            with suppress(InUse):
                self._held(self._hang)

    def _hang(self, control: Control) -> None:
        """Find or make the bell; `control` prevents that two programs do so at the same time."""
        self._bell = Bell.find(self.hub, self._note("bell")) or Bell.make(self.hub, self._note("bell"))

    def _start(self, control: Control) -> None:
        status = self.status()
        if not status.initialised:  # no other program has done so meanwhile
            control.initialise(self._mode(state_of(status, self.settings)))
        control.start()

    def _annotate(self, control: Control, wanted: dict[str, int]) -> None:
        control.annotate(state_of(self.status(), self.settings)._replace(**wanted).to_note())  # type: ignore[arg-type]

    def _configure(self, control: Control, wanted: dict[str, int], loop_back: bool) -> None:
        before = self.status()
        state = state_of(before, self.settings)._replace(loop_back=loop_back, **wanted)  # type: ignore[arg-type]
        control.initialise(self._mode(state, before.mode if "rate" not in wanted else None))
        control.start(abort_pending=False)

    def _mode(self, state: DeviceState, before: LineMode | None = None) -> LineMode:
        """The line's mode for a state; it keeps the timing and the CAN FD settings of `before`, if given."""
        timing = before.timing if before is not None else None
        return LineMode(
            timing or self.controller.timing(state.rate),
            before.data_timing if before is not None else None,
            long_data=before is not None and before.long_data,
            iso_fd=before is None or before.iso_fd,
            error_frames=self.line.capabilities.can(Feature.ERROR_FRAMES),
            listen_only=state.listen,
            low_speed=before is not None and before.low_speed,
            options=None if before is None else before.options,
            standard_filter=_OPEN,
            extended_filter=_OPEN,
            note=state.to_note(),
            keeps=True,
            kin=KIN,
            loop_back=state.loop_back,
        )

    def _held(self, call: Callable[[Control], T]) -> T:
        """Run `call` with the line's control; programs of this dialect wait a moment for each other."""
        for pause_s in (*_PAUSES_S, None):
            try:
                control = self.hub.open_control(self.board.id, self.number, kin=KIN)
            except InUse:
                if pause_s is None:
                    raise
                self.hub.sleep(pause_s)
            else:
                with control:
                    return call(control)
        raise AssertionError


def _given(**values: int | None) -> dict[str, int]:
    """The values that are not None."""
    return {name: value for name, value in values.items() if value is not None}


def unload(hub: Hub, name: str) -> None:
    """Unload the driver, as a restart of the board does: the line loses its configuration, and the next open reads the
    registry again. Raises InUse while a program has the device open, also without read and write access.
    """
    device = Device(hub, name)
    users = device.status().channels
    if users:
        raise InUse(f"{name} {users} programs use its line; end them first")
    if device.is_open():
        raise InUse(f"{name} a program has it open to query it; end that program first")
    with hub.open_control(device.board.id, device.number, kin=KIN) as control:
        control.reset()
    device.virtualize = False
    hub.set_note(settings_note(device.name), b"")
