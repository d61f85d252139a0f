"""The figures of the LIN lines of our boards: the features are the VCI manual's, clock and divisor are simulated.

Source: VCI V4 manual 7.4.1, reference/vci.md section 4, rulings.md 11.
"""

from __future__ import annotations

from canwire.boards.description import LinCapabilities, LinFeature, Ticks

GENERIC_CONTROLLER = 1  # LIN_CTRL_GENERIC

USB_TO_CAN_FD_LIN = LinCapabilities(
    controller_type=GENERIC_CONTROLLER,
    features=int(~LinFeature(0)),
    stamps=Ticks(80_000_000, 80, 0xFFFF_FFFF),  # 1 us
)
"""The LIN line of the USB-to-CAN FD."""
