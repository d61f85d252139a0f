"""What the INT 2Dh interface needs from the library: the functions of acan.api, as a module or an object.

Source: INduCAN104 manual, "Programming interface" and annex A.
"""

# ruff: noqa: N802 - the functions have the manual's names
from __future__ import annotations

from typing import Protocol

from canwire.acan.structures import ACANHI, ACANMB, ACANTB


class Services(Protocol):
    """An initialised library (after ACAN_Init). No function raises: failures are return values, as in C.

    Task Blocks of the INT 2Dh interface have writable views of memory (memoryview) in lpRMB, lpBuf and the lpAddress
    of channels. Their bNotType is TBNT_EVENT and they have no hEvent: cbNotification is called with the block.
    """

    def ACAN_GetDriverVersion(self) -> int:
        """The driver's version, 0xMMmm; 0 if the driver is not operational."""

    def ACAN_GetInitStatus(self) -> int:
        """0xSSTT: SS is not 0 once the hardware is initialised, TT is the type of controller."""

    def ACAN_SetHardConfig(self, lpHI: ACANHI, /) -> bool:  # noqa: N803
        """Initialise the hardware; returns whether that succeeded."""

    def ACAN_GetHardConfig(self, lpHI: ACANHI, /) -> bool:  # noqa: N803
        """Fill in the structure; False if the hardware is not initialised."""

    def ACAN_BusControl(self, bsNewState: int, /) -> int:  # noqa: N803
        """Take the controller on (1) or off (0) the bus; returns 0xOONN, the old and the new state."""

    def ACAN_Register(self, lpTB: ACANTB, /) -> bool:  # noqa: N803
        """Register a block, whose status, counters and occupation the driver then keeps up to date; True on success."""

    def ACAN_AckEventCheck(self, lpTB: ACANTB, /) -> int:  # noqa: N803
        """Return the block's wStatus and set it to 0; 0 for a block that is not registered."""

    def ACAN_Deregister(self, lpTB: ACANTB, /) -> bool:  # noqa: N803
        """Deregister a block; returns whether it was registered."""

    def ACAN_SendMessage(self, lpMsg: ACANMB, bPrio: int, /) -> bool:  # noqa: N803
        """Queue a message with a priority from 0 (sent first) to 255; False if no buffer is free."""

    def ACAN_RetrieveMessages(self, lpTB: ACANTB, /) -> int:  # noqa: N803
        """Move up to wCount messages to lpBuf, ACANMBSZ bytes each, packed; returns how many, -1 for an error."""
