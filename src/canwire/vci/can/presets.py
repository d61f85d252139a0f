"""Bit timings for ICanControl2 with the names of cantype.h.

They are constants: an attempt to change one raises dataclasses.FrozenInstanceError; change its `copy()`. ABR means the
arbitration phase, DBR the data phase, SL and LL short and long lines.
Source: cantype.h of VCI 4.1 (ABR, DBR: not in 4.0); reference/vci.md section 3.
"""

from __future__ import annotations

from dataclasses import FrozenInstanceError
from typing import Any, Self

from canwire.vci.can.structures import CanBtp


class _Preset(CanBtp):
    """bit/s, then the ratios TS1, TS2, SJW, TDO; mode 0."""

    __slots__ = ()

    def __new__(cls, *values: int) -> Self:
        made = super().__new__(cls)
        for member, value in zip(cls._members, (0, *values), strict=True):
            object.__setattr__(made, member.name, value)
        return made

    def __init__(self, *values: int) -> None:
        pass

    def __setattr__(self, name: str, value: object) -> None:
        raise FrozenInstanceError(f"a CAN_BTP_ constant: set {name} of its copy()")

    def __reduce__(self) -> tuple[Any, ...]:
        return CanBtp, tuple(getattr(self, member.name) for member in self._members)

    def __repr__(self) -> str:
        return repr(self.copy())


CAN_BTP_EMPTY: CanBtp = _Preset(0, 0, 0, 0, 0)
CAN_BTP_5KB: CanBtp = _Preset(5_000, 17, 8, 1, 0)
CAN_BTP_10KB: CanBtp = _Preset(10_000, 14, 2, 1, 0)
CAN_BTP_20KB: CanBtp = _Preset(20_000, 14, 2, 1, 0)
CAN_BTP_50KB: CanBtp = _Preset(50_000, 14, 2, 1, 0)
CAN_BTP_100KB: CanBtp = _Preset(100_000, 14, 2, 1, 0)
CAN_BTP_125KB: CanBtp = _Preset(125_000, 14, 2, 1, 0)
CAN_BTP_250KB: CanBtp = _Preset(250_000, 14, 2, 1, 0)
CAN_BTP_500KB: CanBtp = _Preset(500_000, 14, 2, 1, 0)
CAN_BTP_800KB: CanBtp = _Preset(800_000, 8, 2, 1, 0)
CAN_BTP_1000KB: CanBtp = _Preset(1_000_000, 6, 2, 1, 0)

CAN_BTP_ABR_SL_500KB: CanBtp = _Preset(500_000, 6400, 1600, 1600, 0)
CAN_BTP_DBR_SL_1000KB: CanBtp = _Preset(1_000_000, 1600, 400, 400, 1600)
CAN_BTP_DBR_SL_2000KB: CanBtp = _Preset(2_000_000, 1600, 400, 400, 1600)
CAN_BTP_DBR_SL_4000KB: CanBtp = _Preset(4_000_000, 800, 200, 200, 800)
CAN_BTP_DBR_SL_5000KB: CanBtp = _Preset(5_000_000, 600, 200, 200, 600)
CAN_BTP_DBR_SL_6667KB: CanBtp = _Preset(6_666_666, 400, 200, 200, 402)
CAN_BTP_DBR_SL_8000KB: CanBtp = _Preset(8_000_000, 400, 100, 100, 250)
CAN_BTP_DBR_SL_10000KB: CanBtp = _Preset(10_000_000, 300, 100, 100, 200)

CAN_BTP_ABR_LL_250KB: CanBtp = _Preset(250_000, 6400, 1600, 1600, 0)
CAN_BTP_DBR_LL_500KB: CanBtp = _Preset(500_000, 6400, 1600, 1600, 6400)
CAN_BTP_DBR_LL_833KB: CanBtp = _Preset(833_333, 1600, 400, 400, 1620)
CAN_BTP_DBR_LL_1000KB: CanBtp = _Preset(1_000_000, 1600, 400, 400, 1600)
CAN_BTP_DBR_LL_1538KB: CanBtp = _Preset(1_538_461, 1000, 300, 300, 1040)
CAN_BTP_DBR_LL_2000KB: CanBtp = _Preset(2_000_000, 800, 200, 200, 770)
CAN_BTP_DBR_LL_4000KB: CanBtp = _Preset(4_000_000, 800, 200, 200, 800)
