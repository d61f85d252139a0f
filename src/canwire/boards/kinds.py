"""The boards that canwire includes, as rows: names, descriptions and controllers."""

from __future__ import annotations

from canwire.boards import figures, inducan104
from canwire.boards.board import CAN, LIN, MCP2515, SJA1000, BoardKind, Connector
from canwire.boards.lin.description import USB_TO_CAN_FD_LIN

USUAL_BUS = "can0"
USUAL_LIN_BUS = "lin0"
USUAL_BOARDS = ("usb-to-can-fd", "usb-to-can", inducan104.KIND, "picocom1")
"""What is plugged in where nobody says anything else (source: rulings.md 30)."""
SLCAN, SLCAN_FD, PYTHON_CAN = "slcan", "slcan-fd", "python-can"
F_AND_S_CHANNELS = (2, 3)
"""To receive and to send with: as many as the controller has registers for (source: CANDRV manual, 7.3)."""

KINDS = {
    kind.name: kind
    for kind in (
        BoardKind(
            name="usb-to-can-fd",
            device_class="B9AAAF39-B9B9-4850-9402-7D8250C7B88F",
            description="USB-to-CAN FD (simulated)",
            connectors=(
                Connector(CAN, figures.USB_TO_CAN_FD, USUAL_BUS),
                Connector(CAN, figures.USB_TO_CAN_FD, USUAL_BUS),
                Connector(LIN, USB_TO_CAN_FD_LIN, USUAL_LIN_BUS),
            ),
        ),
        BoardKind(
            name="usb-to-can",
            device_class="2219F6A0-732A-4750-B66F-0AE731FB40E1",
            description="USB-to-CAN V2 (simulated)",
            connectors=(Connector(CAN, figures.USB_TO_CAN, USUAL_BUS),) * 2,
        ),
        BoardKind(
            name=inducan104.KIND,
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA0104A",  # ours: VCI never knew the board
            description="INduCAN104 (simulated)",
            connectors=(Connector(CAN, figures.SJA1000_LINE, USUAL_BUS, SJA1000),),
            isa=True,
        ),
        BoardKind(
            name="pc-i04",
            device_class="E7752D2E-28A3-4318-AF0C-02C756FBC25A",
            description="PC-I04/PCI (simulated)",
            connectors=(Connector(CAN, figures.PASSIVE_LINE, USUAL_BUS, SJA1000),),
        ),
        BoardKind(
            name="netdcu",
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA0DC00",  # ours, as VCI never knew F&S boards
            description="NetDCU (simulated)",
            connectors=(Connector(CAN, figures.SJA1000_LINE, USUAL_BUS, SJA1000, *F_AND_S_CHANNELS),),
        ),
        *(
            BoardKind(
                name=name.lower(),
                device_class=f"2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA0{number}",  # ours
                description=f"{name} (simulated)",
                connectors=(Connector(CAN, figures.MCP2515_LINE, USUAL_BUS, MCP2515, *F_AND_S_CHANNELS),),
            )
            for name, number in (
                ("PicoCOM1", "0C01"),
                ("PicoCOM2", "0C02"),
                ("PicoCOM4", "0C04"),
                ("PicoMOD3", "0D03"),
            )
        ),
        BoardKind(
            name="canbus-dongle",
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA0B051",  # ours
            description="CANBUS dongle (simulated)",
            connectors=(Connector(CAN, figures.SJA1000_LINE, USUAL_BUS, SJA1000),),
        ),
        BoardKind(
            name=SLCAN,
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA05CA1",  # ours
            description="serial CAN adapter",
            manufacturer="",
            connectors=(Connector(CAN, figures.SERIAL_ADAPTER, ""),),
            outside=True,
        ),
        BoardKind(
            name=SLCAN_FD,
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA0FDCA",  # ours
            description="serial CAN FD adapter",
            manufacturer="",
            connectors=(Connector(CAN, figures.SERIAL_FD_ADAPTER, ""),),
            outside=True,
        ),
        BoardKind(
            name=PYTHON_CAN,
            device_class="2A0F3B61-6F0A-4C0D-9C1B-5D1E5CA09CA1",  # ours
            description="adapter of python-can",
            manufacturer="",
            connectors=(Connector(CAN, figures.ADAPTER, ""),),
            outside=True,
        ),
    )
}
"""Our own kinds. Their device classes are those of the real boards, so that programs that look for one find it
(source: reference/vci.md section 6)."""
