"""What the INT 2Dh interface needs of the library: the functions of acan.api, as a module or an object.

Source: INduCAN104 manual, "Programming interface" and annex A.
"""

# ruff: noqa: N802 - the functions have the manual's names
from __future__ import annotations

from typing import Protocol

from canwire.acan.structures import ACANHI, ACANMB, ACANTB


class Services(Protocol):
    """An initialised library (after ACAN_Init). Nothing here raises: failures are answers, as in C.

    Task Blocks of the INT 2Dh interface have writable pieces of memory (memoryview) in lpRMB, lpBuf and channels'
    lpAddress; notified as TBNT_EVENT, with no hEvent of their own, their cbNotification is called with the block.
    """

    def ACAN_GetDriverVersion(self) -> int:
        """0xMMmm; 0 if the driver is not operational."""

    def ACAN_GetInitStatus(self) -> int:
        """0xSSTT: SS not 0 once the hardware is initialised, TT the type of controller."""

    def ACAN_SetHardConfig(self, lpHI: ACANHI, /) -> bool:  # noqa: N803
        """Whether the hardware is initialised like this now."""

    def ACAN_GetHardConfig(self, lpHI: ACANHI, /) -> bool:  # noqa: N803
        """Fill the structure in; False if the hardware is not initialised."""

    def ACAN_BusControl(self, bsNewState: int, /) -> int:  # noqa: N803
        """Go on (1) or off (0) the bus; 0xOONN: old state, new state."""

    def ACAN_Register(self, lpTB: ACANTB, /) -> bool:  # noqa: N803
        """From now on the driver keeps the block's status, counters and occupation up to date."""

    def ACAN_AckEventCheck(self, lpTB: ACANTB, /) -> int:  # noqa: N803
        """The block's wStatus, which is 0 then; 0 for a block that is not registered."""

    def ACAN_Deregister(self, lpTB: ACANTB, /) -> bool:  # noqa: N803
        """Whether the block was registered."""

    def ACAN_SendMessage(self, lpMsg: ACANMB, bPrio: int, /) -> bool:  # noqa: N803
        """Send with a priority from 0 (first) to 255; False if there is no room."""

    def ACAN_RetrieveMessages(self, lpTB: ACANTB, /) -> int:  # noqa: N803
        """Move up to wCount messages to lpBuf, packed, ACANMBSZ bytes each; how many, -1 for an error."""
