"""ACAN programs: one by the C library, one by INT 2Dh."""

from __future__ import annotations

from typing import Any

import canwire
from canwire import acan
from canwire.acan import ACANHI, ACANID, ACANMB, ACANMBSZ, ACANTB, Action, Condition, HardConfig
from canwire.acan.identifiers import acan_word
from canwire.acan.int2d import Int2d
from canwire.acan.real_mode import ByteMemory, FarPointer, Registers
from tests.together.players.player import NO_CALL, RATE, Player, fresh

_FIFO = 64
_ALL_CONDITIONS = 0xFF
_CONFIG, _BLOCK, _MESSAGE = FarPointer(0x2000, 0), FarPointer(0x2100, 0), FarPointer(0x2200, 0)
_RMB, _BUFFER = FarPointer(0x3000, 0), FarPointer(0x4000, 0)


_EVERY_INTERRUPT = 0xED  # arbitration lost among them, which the default leaves out


def _config(rate: int, *, narrow: bool = False) -> HardConfig:
    own, mask = (acan_word(0x200), acan_word(0x700)) if narrow else (0, 0)
    return HardConfig(
        own, mask, own, mask, rate_kbps=rate // 1000, ts1=13, ts2=3, interrupts=_EVERY_INTERRUPT
    )


class AcanApi(Player):
    """ACAN.H: failures are FALSE or 0."""

    kind = "acan"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._api: Any = fresh("canwire.acan.api")
        self._api.use(hub)
        self._block: Any = ACANTB()

    def join(self) -> str:
        if not self._init():
            return "ACAN_Init 0"
        return "done" if self._register() else "FALSE"

    def set_up(self) -> str:
        if not self._init():
            return "ACAN_Init 0"
        told = self.set_rate(RATE)
        return told if told != "done" or self._register() else "FALSE"

    def set_rate(self, rate: int) -> str:
        if not self._set_hard_config(_config(rate)):
            return "FALSE"
        return self._on("0x0001")

    def stop(self) -> str:
        return self._answered(self._bus_control(0), "0x0100")

    def recover(self) -> str:
        return self._on("0x0001")

    def _on(self, wanted: str) -> str:
        return self._answered(self._bus_control(1), wanted)

    def _answered(self, words: int, wanted: str) -> str:
        return "done" if f"{words:#06x}" == wanted else f"{words:#06x}"

    def send(self, identifier: int) -> str:
        return "done" if self._send(ACANMB(identifier << 18)) else "FALSE"

    def received(self) -> list[int]:
        found = []
        while message := self._retrieve():
            found.append(message.dwID >> 18)
        return found

    def told(self) -> set[str]:
        while self._retrieve():
            pass
        conditions = Condition(self._acknowledge() >> 8)
        return {f"SC_{one.name}" for one in Condition if one in conditions}

    def narrow(self) -> str:
        if not self._set_hard_config(_config(RATE, narrow=True)):
            return "FALSE"
        return self._on("0x0001")

    def state(self) -> str:
        """The hardware's state, and what special conditions told; FALSE for a configuration that cannot be had."""
        if self._init_status() == 0:
            return "0x0000"
        hi = ACANHI()
        if not self._get_hard_config(hi):
            return "ACAN_GetHardConfig FALSE"
        conditions = self._acknowledge() >> 8
        return "SC_BUSOFF" if conditions & acan.SC_BUSOFF else f"0x0100, hi_rat {hi.hi_rat}"

    def end(self) -> None:
        self._api.ACAN_Exit()
        self.hub.close()

    # the library's calls; INT 2Dh has its own

    def _init(self) -> bool:
        return bool(self._api.ACAN_Init())

    def _init_status(self) -> int:
        return int(self._api.ACAN_GetInitStatus())

    def _register(self) -> bool:
        self._rmb = bytearray(_FIFO * ACANMBSZ)
        self._buffer = bytearray(ACANMBSZ)
        self._block = ACANTB(
            bSCFilter=_ALL_CONDITIONS,
            lpRMB=self._rmb,
            wRMBSize=_FIFO,
            lpBuf=self._buffer,
            wCount=1,
            idTable=[ACANID(bAction=Action.QUEUE)],
        )
        return bool(self._api.ACAN_Register(self._block))

    def _set_hard_config(self, config: HardConfig) -> bool:
        return bool(self._api.ACAN_SetHardConfig(config.to_hi()))

    def _get_hard_config(self, hi: ACANHI) -> bool:
        return bool(self._api.ACAN_GetHardConfig(hi))

    def _bus_control(self, state: int) -> int:
        return int(self._api.ACAN_BusControl(state))

    def _send(self, message: ACANMB) -> bool:
        return bool(self._api.ACAN_SendMessage(message, 1))

    def _retrieve(self) -> Any:
        if self._api.ACAN_RetrieveMessages(self._block) != 1:
            return None
        return ACANMB.unpack(bytes(self._buffer))

    def _acknowledge(self) -> int:
        return int(self._api.ACAN_AckEvent(self._block))


class AcanInt2d(AcanApi):
    """An assembly language program, over INT 2Dh."""

    kind = "acan int 2dh"

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        super().__init__(hub, board)
        self._memory = ByteMemory()
        self._driver: Int2d | None = None

    def _init(self) -> bool:
        """The resident part is there as soon as it finds a controller."""
        if not super()._init():
            return False
        self._driver = self._driver or Int2d(self._api, self._memory)
        return bool(self._call(acan.ACAN_GET_VERSION_1).AX)

    def _init_status(self) -> int:
        found = self._call(acan.ACAN_GET_VERSION)
        return found.DH << 8 | found.DL if found.DH else 0

    def _register(self) -> bool:
        block = ACANTB(
            wTid=3,
            wEvent=4,
            bSCFilter=_ALL_CONDITIONS,
            lpRMB=_far(_RMB),
            wRMBSize=_FIFO,
            lpBuf=_far(_BUFFER),
            wCount=1,
            idTable=[ACANID(bAction=Action.QUEUE)],
        )
        self._memory.write(_BLOCK, block.pack())
        return self._call(acan.ACAN_REGISTER, _BLOCK).AX == 1

    def _set_hard_config(self, config: HardConfig) -> bool:
        self._memory.write(_CONFIG, config.pack())
        return self._call(acan.ACAN_HARD_CONFIGURE, _CONFIG).AX == 1

    def _get_hard_config(self, hi: ACANHI) -> bool:
        answer = self._call(acan.ACAN_HARD_STATUS, _CONFIG).AX
        hi.assign(ACANHI.unpack(self._memory.read(_CONFIG, ACANHI.SIZE)))
        return answer == 1

    def _bus_control(self, state: int) -> int:
        return self._call(acan.ACAN_HARD_CONTROL, DL=state).AX

    def _send(self, message: ACANMB) -> bool:
        self._memory.write(_MESSAGE, message.pack())
        return self._call(acan.ACAN_SEND, _MESSAGE, CL=1).AX == 1

    def _retrieve(self) -> Any:
        if self._call(acan.ACAN_RECEIVE, _BLOCK).AX != 1:
            return None
        return ACANMB.unpack(self._memory.read(_BUFFER, ACANMBSZ))

    def _acknowledge(self) -> int:
        return self._call(acan.ACAN_ACK, _BLOCK).AX

    def _call(self, service: int, at: FarPointer = _CONFIG, **more: int) -> Registers:
        assert self._driver is not None
        registers = Registers(AX=service, ES=at.segment, BX=at.offset)
        for name, value in more.items():
            setattr(registers, name, value)
        self._driver.call_far(registers)
        return registers


def _far(at: FarPointer) -> int:
    return at.segment << 16 | at.offset


__all__ = ["NO_CALL", "AcanApi", "AcanInt2d"]
