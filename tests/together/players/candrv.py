"""CANDRV programs: one with handles as Python objects, one with Win32's functions. CID1: is the line of the matrix."""

from __future__ import annotations

import struct
from contextlib import suppress
from typing import Any

import canwire
from canwire import candrv
from canwire.candrv.constants import (
    CANBUS_EVENT_BUS_ERROR,
    CANBUS_EVENT_RECEIVED,
    GENERIC_READ,
    GENERIC_WRITE,
    INVALID_HANDLE_VALUE,
    IOCTL_CAN_GET_BAUDRATE,
    IOCTL_CAN_INIT,
    IOCTL_CAN_READ_EVENT_DATA,
    IOCTL_CAN_SET_BAUDRATE,
    IOCTL_CAN_TEST_DEVICE,
    IOCTL_CAN_WRITE_ACCEPTANCE_FILTER,
    OPEN_EXISTING,
    CanbusEvent,
    Win32Error,
)
from canwire.candrv.program import Program
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER, CAN_EVENT
from tests.together.players.player import DONE, RATE, Player, fresh

REGISTRY = f'[candrv.CID1]\nBoard = "HW000001"\nBaudrate = {RATE}\n'


class CandrvHandle(Player):
    kind = "candrv"
    shows = candrv.CandrvError

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._handle: Any = None

    def name_of(self, error: Any) -> str:
        return str(error.name)

    def join(self) -> str:
        return self.tell(self._open)

    def set_up(self) -> str:
        return self.tell(self._open)

    def _open(self) -> None:
        self._handle = candrv.open("CID1:", hub=self.hub)
        self._handle.accept_all()
        self._handle.timeouts = candrv.COMMTIMEOUTS(0xFFFF_FFFF, 0, 0, 0, 1)

    def set_rate(self, rate: int) -> str:
        def change() -> None:
            self._handle.baud_rate = rate

        return self.tell(change)

    def reset(self) -> str:
        """IOCTL_CAN_INIT, which sets the controller up anew."""
        return self.tell(self._handle.initialise)

    def recover(self) -> str:
        return self.tell(self._handle.initialise)

    def send(self, identifier: int) -> str:
        return self.tell(lambda: self._handle.write(f"{identifier:x} 0 0\n") and None)

    def received(self) -> list[int]:
        return [event.identifier for event in self._events() if event.event == CANBUS_EVENT_RECEIVED]

    def told(self) -> set[str]:
        return {f"CANBUS_EVENT_{CanbusEvent(event.event).name}" for event in self._events()}

    def narrow(self) -> str:
        """Align 0: identifiers in bits 31..21; any data."""

        def choose() -> None:
            self._handle.filter = candrv.Filter(0x200 << 21, 0xFF << 21 | 0xFFFF)

        return self.tell(choose)

    def _events(self) -> list[Any]:
        found = []
        while self._handle.waiting:
            found.append(self._handle.read_event())
        return found

    def state(self) -> str:
        def look() -> str:
            if any(event.event == CANBUS_EVENT_BUS_ERROR for event in self._events()):
                return "CANBUS_EVENT_BUS_ERROR"
            if self._handle.in_configuration_mode():
                return "in configuration mode"
            return f"baud rate {self._handle.baud_rate}"

        return self.tell(look)

    def end(self) -> None:
        if self._handle is not None:
            with suppress(candrv.CandrvError):
                self._handle.close()
        self.hub.close()


class CandrvWin32(Player):
    kind = "candrv win32"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._win32: Any = fresh("canwire.candrv.win32")
        self._win32.PROGRAM = Program()
        self._win32.use(hub)
        self._device = INVALID_HANDLE_VALUE

    def _answer(self, answer: int, failure: int = 0) -> str:
        return Win32Error(self._win32.GetLastError()).name if answer == failure else DONE

    def join(self) -> str:
        self._device = self._win32.CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 3, None, OPEN_EXISTING)
        told = self._answer(self._device, INVALID_HANDLE_VALUE)
        if told != DONE:
            return told
        everything = CAN_ACCEPTANCE_FILTER(0, 0xFFFF_FFFF)
        self._win32.SetCommTimeouts(self._device, candrv.COMMTIMEOUTS(0xFFFF_FFFF, 0, 0, 0, 1))
        return self._control(IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, everything.pack())

    def set_up(self) -> str:
        return self.join()

    def set_rate(self, rate: int) -> str:
        return self._control(IOCTL_CAN_SET_BAUDRATE, struct.pack("<I", rate))

    def reset(self) -> str:
        return self._control(IOCTL_CAN_INIT)

    def recover(self) -> str:
        return self._control(IOCTL_CAN_INIT)

    def _control(self, code: int, given: bytes = b"") -> str:
        return self._answer(self._win32.DeviceIoControl(self._device, code, given or None, len(given)))

    def send(self, identifier: int) -> str:
        text = f"{identifier:x} 0 0\n".encode()
        return self._answer(self._win32.WriteFile(self._device, text, len(text), [0]))

    def received(self) -> list[int]:
        return [event.data.identifier for event in self._events() if event.event == CANBUS_EVENT_RECEIVED]

    def told(self) -> set[str]:
        return {f"CANBUS_EVENT_{CanbusEvent(event.event).name}" for event in self._events()}

    def narrow(self) -> str:
        chosen = CAN_ACCEPTANCE_FILTER(0x200 << 21, 0xFF << 21 | 0xFFFF)
        return self._control(IOCTL_CAN_WRITE_ACCEPTANCE_FILTER, chosen.pack())

    def _events(self) -> list[Any]:
        found = []
        while (event := self._next()) is not None:
            found.append(event)
        return found

    def _next(self) -> Any:
        event = CAN_EVENT()
        code, size = IOCTL_CAN_READ_EVENT_DATA, CAN_EVENT.SIZE
        return event if self._win32.DeviceIoControl(self._device, code, None, 0, event, size, [0]) else None

    def state(self) -> str:
        if any(event.event == CANBUS_EVENT_BUS_ERROR for event in self._events()):
            return "CANBUS_EVENT_BUS_ERROR"
        self._win32.SetLastError(0)
        if self._win32.DeviceIoControl(self._device, IOCTL_CAN_TEST_DEVICE):
            return "in configuration mode"
        if self._win32.GetLastError():
            return Win32Error(self._win32.GetLastError()).name
        rate = bytearray(4)
        told = self._answer(
            self._win32.DeviceIoControl(self._device, IOCTL_CAN_GET_BAUDRATE, None, 0, rate, 4, [0])
        )
        return f"baud rate {struct.unpack('<I', rate)[0]}" if told == DONE else told

    def end(self) -> None:
        if self._device != INVALID_HANDLE_VALUE:
            self._win32.CloseHandle(self._device)
            self._device = INVALID_HANDLE_VALUE
        self.hub.close()
