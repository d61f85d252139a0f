"""ACAN.EXE as assembly language programs see it: they find it through INT 2Dh and call it at its entry point.

    memory = ByteMemory()
    driver = Int2d(acan.api, memory)          # sets the interrupt vector, writes the signature into memory
    multiplex = find_driver(memory, driver.interrupt)
    driver.call_far(registers)                # AL = service, ES:BX = structure, see annex A

Structures are packed in memory. The manual's `his` is ACANHI, `ambs` is ACANMB, and `tbs` is ACANTB, whose wStatus is
tb_wsta, with tb_sta as its low byte and tb_sca as its high byte. The status, counters and occupation of a registered
Task Block are written into memory when they change, as the driver's interrupt routine did (rulings.md 40). On a hub in
virtual time no thread works between two services, so they are written in each service.
Source: INduCAN104 manual, annex A; Alternate Multiplex Interrupt Specification 3.6.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable

from canwire import BadValue
from canwire.acan.constants import IDA_CHANRCV, IDA_CHANSND, TBNT_EVENT, Service
from canwire.acan.real_mode import ByteMemory, FarPointer, Registers
from canwire.acan.services import Services
from canwire.acan.structures import ACANHI, ACANHISZ, ACANID, ACANIDSZ, ACANMB, ACANMBSZ, ACANTB, ACANTBSZ

VECTOR = FarPointer(0x0000, 0x00B4)  # of interrupt 2Dh

VENDOR, PRODUCT = (
    b"Aton Sys",
    b"ACAN    ",
)  # eight characters each; the manual's "At on" is a misread (rulings.md 39)
SIGNATURE = VENDOR + PRODUCT
DESCRIPTION = b"ATON Controller Area Network Driver"
VERSION = 0x0100

_FOUND = 0xFF
_NOT_IMPLEMENTED = 0x00
_CANNOT_BE_UNINSTALLED, _DEACTIVATED = 0x01, 0x04
_TRAPPED_LIST = 0x04
_IRET, _RETF = b"\xcf", b"\xcb"
_SEGMENT = 0x0C00  # DOS could load it anywhere
_NULL = FarPointer(0, 0)
_TO_THE_STATUS = struct.Struct("<HBBBB")  # wStatus, bREC, bTEC, bALC, bECC
_TO_THE_FIFO = struct.Struct("<HHH")  # wRMBOccupation, wRIndex, wWIndex


class Int2d:
    """The resident driver: `interrupt` is INT 2Dh, `call_far` is a far call to `entry_point`.

    It handles only calls with AH = `multiplex`; other calls change no register. `trapped` lists further interrupts that
    the driver reports as its own (IRQ 5 is 0Dh; with ADTM the monitor holds that one). To notify an application it
    calls `notify_event(wTid, wEvent)`, as ADTM does, on the thread on which the services notify.
    """

    def __init__(
        self,
        services: Services,
        memory: ByteMemory,
        multiplex: int = 0xC0,
        *,
        segment: int = _SEGMENT,
        trapped: Iterable[int] = (),
        notify_event: Callable[[int, int], object] | None = None,
    ) -> None:
        if not 1 <= multiplex <= 0xFF:
            raise BadValue(
                f"multiplex {multiplex!r:.40}: a number from 1 to 0xFF; programs end their search at 0"
            )
        self.multiplex = multiplex
        self.active = True
        self._services = services
        self._memory = memory
        self._notify_event = notify_event
        self._blocks: dict[int, tuple[FarPointer, ACANTB]] = {}
        self._load(FarPointer(segment, 0), trapped)
        self._before = memory.read_pointer(VECTOR)
        memory.write_pointer(VECTOR, self._handler)

    def _load(self, at: FarPointer, trapped: Iterable[int]) -> None:
        """Write code and texts into memory. Each trapped interrupt is a number and an offset; 2Dh is the last."""
        text = SIGNATURE + DESCRIPTION + b"\0\0"
        self._signature, self._handler = at, at + len(text)
        self.entry_point = self._handler + 1
        self._trapped = self.entry_point + 1
        numbers = [*(one for one in trapped if one != 0x2D), 0x2D]
        listed = b"".join(struct.pack("<BH", one, self._handler.offset) for one in numbers)
        self._memory.write(at, text + _IRET + _RETF + listed)

    def interrupt(self, registers: Registers) -> None:
        """INT 2Dh with AH and AL from the registers; writes the answer into the registers."""
        if not self.active or self.multiplex != registers.AH:
            return
        function, registers.AL = registers.AL, _NOT_IMPLEMENTED
        if function == 0:
            registers.AL, registers.CX = _FOUND, VERSION
            registers.point("DX", "BX", self._signature)
        elif function == 1:
            registers.AL = _FOUND
            registers.point("DX", "BX", self.entry_point)
        elif function == 2:
            self._uninstall(registers)
        elif function == 4:
            registers.AL = _TRAPPED_LIST
            registers.point("DX", "BX", self._trapped)

    def _uninstall(self, registers: Registers) -> None:
        """Uninstall, except while Task Blocks are registered or if another program has replaced the vector."""
        if self._blocks or self._memory.read_pointer(VECTOR) != self._handler:
            registers.AL = _CANNOT_BE_UNINSTALLED
            return
        self._memory.write_pointer(VECTOR, self._before)
        self.active = False
        registers.AL, registers.BX = _DEACTIVATED, self._handler.segment

    def call_far(self, registers: Registers) -> None:
        """Run the service in AL. Only AX and DX change. AX is 0 (RECEIVE: -1) for an error or an unknown service."""
        code = registers.AL
        registers.AX = 0
        if not self.active or code not in _SERVICES:
            return
        try:
            _SERVICES[code](self, registers)
        except BadValue:  # the structure reaches over the end of the memory
            registers.AX = 0xFFFF if code == Service.RECEIVE else 0
        self.refresh()

    def refresh(self) -> None:
        """Write status, counters and occupation of all registered Task Blocks into memory."""
        for at, block in list(self._blocks.values()):
            self._mirror(at, block)

    # the services

    def _get_version(self, registers: Registers) -> None:
        registers.AX = self._services.ACAN_GetDriverVersion()
        status = self._services.ACAN_GetInitStatus()
        registers.DL, registers.DH = status & 0xFF, int(status > 0xFF)

    def _hard_configure(self, registers: Registers) -> None:
        hi = ACANHI.unpack(self._memory.read(_structure(registers), ACANHISZ))
        registers.AX = int(self._services.ACAN_SetHardConfig(hi))

    def _hard_status(self, registers: Registers) -> None:
        registers.DL = self._services.ACAN_GetInitStatus() & 0xFF
        at, hi = _structure(registers), ACANHI()
        self._memory.view(at, ACANHISZ)
        if self._services.ACAN_GetHardConfig(hi):
            self._memory.write(at, hi.pack())
            registers.AX = 1

    def _hard_control(self, registers: Registers) -> None:
        registers.AX = self._services.ACAN_BusControl(int(registers.DL != 0))

    def _register(self, registers: Registers) -> None:
        at = _structure(registers)
        if at.linear in self._blocks:
            return
        block = self._block(at)
        if block.bNotType == TBNT_EVENT and self._services.ACAN_Register(block):
            self._blocks[at.linear] = at, block
            registers.AX = 1

    def _ack(self, registers: Registers) -> None:
        if found := self._blocks.get(registers.pointer("ES", "BX").linear):
            registers.AX = self._services.ACAN_AckEventCheck(found[1])

    def _free(self, registers: Registers) -> None:
        linear = registers.pointer("ES", "BX").linear
        if (found := self._blocks.get(linear)) and self._services.ACAN_Deregister(found[1]):
            self._mirror(*self._blocks.pop(linear))
            registers.AX = 1

    def _send(self, registers: Registers) -> None:
        message = ACANMB.unpack(self._memory.read(_structure(registers), ACANMBSZ))
        registers.AX = int(self._services.ACAN_SendMessage(message, registers.CL))

    def _receive(self, registers: Registers) -> None:
        at, block = self._blocks.get(registers.pointer("ES", "BX").linear, (_NULL, None))
        if block is None:
            raise BadValue(f"no Task Block at {registers.pointer('ES', 'BX')}")
        now = ACANTB.unpack_head(self._memory.read(at, ACANTBSZ))  # both may change from call to call
        block.wCount = now.wCount
        block.lpBuf = self._view(now.lpBuf, now.wCount * ACANMBSZ)
        registers.AX = self._services.ACAN_RetrieveMessages(block) & 0xFFFF

    # Task Blocks in memory

    def _block(self, at: FarPointer) -> ACANTB:
        """The Task Block at this address, with views of the memory in place of pointers."""
        count = ACANTB.unpack_head(self._memory.read(at, ACANTBSZ)).bNId
        block = ACANTB.unpack(self._memory.read(at, ACANTBSZ + count * ACANIDSZ))
        block.lpRMB = self._view(block.lpRMB, block.wRMBSize * ACANMBSZ)
        block.lpBuf = self._view(block.lpBuf, block.wCount * ACANMBSZ)
        for one in block.idTable:
            one.lpAddress = self._view(one.lpAddress, one.bLength) if _is_channel(one) else None
        block.cbNotification = lambda _block: self._notify(at, block)
        block.on_change = lambda: self._mirror(at, block)
        return block

    def _view(self, pointer: int | None, size: int) -> memoryview | None:
        return None if pointer is None else self._memory.view(FarPointer.of(pointer), size)

    def _notify(self, at: FarPointer, block: ACANTB) -> None:
        self._mirror(at, block)
        if self._notify_event is not None:
            self._notify_event(block.wTid, block.wEvent)

    def _mirror(self, at: FarPointer, block: ACANTB) -> None:
        status = _TO_THE_STATUS.pack(block.wStatus, block.bREC, block.bTEC, block.bALC, block.bECC)
        fifo = _TO_THE_FIFO.pack(block.wRMBOccupation, block.wRIndex, block.wWIndex)
        self._memory.write(at + ACANTB.OFFSETS["wStatus"], status)
        self._memory.write(at + ACANTB.OFFSETS["wRMBOccupation"], fifo)


def _structure(registers: Registers) -> FarPointer:
    at = registers.pointer("ES", "BX")
    if not at:
        raise BadValue("ES:BX is NULL")
    return at


def _is_channel(one: ACANID) -> bool:
    return bool(one.bAction & (IDA_CHANRCV | IDA_CHANSND))


_SERVICES: dict[int, Callable[[Int2d, Registers], None]] = {
    Service.GET_VERSION: Int2d._get_version,
    Service.HARD_CONFIGURE: Int2d._hard_configure,
    Service.HARD_STATUS: Int2d._hard_status,
    Service.HARD_CONTROL: Int2d._hard_control,
    Service.REGISTER: Int2d._register,
    Service.ACK: Int2d._ack,
    Service.FREE: Int2d._free,
    Service.SEND: Int2d._send,
    Service.RECEIVE: Int2d._receive,
    Service.GET_VERSION_1: Int2d._get_version,
}


def find_driver(memory: ByteMemory, interrupt: Callable[[Registers], object]) -> int | None:
    """The multiplex number of the ACAN driver, by the manual's algorithm; None if the driver is not installed.

    `interrupt` performs INT 2Dh on registers. Source: annex A, "ACAN driver detection".
    """
    if not memory.read_pointer(VECTOR):
        return None
    for multiplex in range(0x100):
        registers = Registers(AX=multiplex << 8)
        interrupt(registers)
        signature = registers.pointer("DX", "BX")
        if registers.AL == _FOUND and memory.read(signature, len(SIGNATURE)) == SIGNATURE:
            return multiplex
    return None
