"""Classes of devices by the names of the vendor's headers."""

from __future__ import annotations

import pytest

from canwire import vci
from tests.cases import each

VENDOR = [
    "PCI04PCI",
    "IPCI165PCI",
    "IPCI320PCI",
    "IPCIXC16PCI",
    "IPCIXC16PCIE",
    "USB2CANCOMPACT",
    "USB2CANII",
    "USB2CANV2",
    "USB2CANFD",
    "CANIB100_PCIE",
    "CANIB200_PCIE",
    "CANIB300_PCI",
    "CANIB400_PCI",
    "CANIB500_PCIE",
    "CANIB600_PCIE",
    "CANIB640_PCIE",
    "CANIB700_PCI",
    "CANIB800_PCI",
    "CANBLUE",
    "CANBLUE2",
    "CANATNET2",
    "USB_CANATNET_NT",
    "ETH_CANATNET_NT",
    "USB_CANBRIDGE",
    "INPACT",
    "DEMO",
]
FIRST = {"USB2CAN_FD": "USB2CANFD", "USB2CAN_V2": "USB2CANV2", "PC_I04_PCI": "PCI04PCI",
         "CAN_IB600_PCIE": "CANIB600_PCIE", "CANBLUE_II": "CANBLUE2"}  # fmt: skip


@pytest.mark.finding("vci F2")
def test_the_vendors_names() -> None:
    values = [getattr(vci, f"GUID_{name}_DEVICE") for name in VENDOR]
    assert len(set(values)) == len(VENDOR) == 26


@pytest.mark.finding("vci F2")
@each("name", FIRST)
def test_names_that_canwire_had_first_go_on_working(name: str) -> None:
    assert getattr(vci, f"GUID_{name}_DEVICE") == getattr(vci, f"GUID_{FIRST[name]}_DEVICE")
