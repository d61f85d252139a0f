"""The registry dialog: what it shows, what OK writes, and when that counts."""

from __future__ import annotations

import pytest

from canwire import BadValue
from canwire.candrv import RegistryStore, unload
from canwire.candrv.registry.settings import ROWS
from canwire.web.cancheck.program import CanCheck
from canwire.web.cancheck.registry import Entry, RegistryDialog, ports
from tests.candrv.bench import Bench

pytestmark = pytest.mark.conforms("FT-07")


def entry(name: str) -> Entry:
    return {one.name: one for one in RegistryDialog("CID1:").entries()}[name]


def test_it_shows_every_entry_and_the_filter_in_hex(registry: RegistryStore) -> None:
    registry.merge({"CID1": {"AcceptanceCode": 0xABCD, "Baudrate": 500_000}})
    assert [one.name for one in RegistryDialog("CID1:").entries()] == list(ROWS)
    assert entry("AcceptanceCode").value == "0000ABCD"
    assert entry("AcceptanceMask").value == "00000000"
    assert entry("Baudrate").value == "500000"
    assert [one.name for one in RegistryDialog("CID1:").entries() if one.hexadecimal] == [
        "AcceptanceCode",
        "AcceptanceMask",
    ]


def test_enumerations_are_lists_and_numbers_are_typed() -> None:
    assert entry("Align").choices == ("0", "1", "2", "3")
    assert entry("CanMode2B").choices == ("0", "1")
    assert entry("UseTxIRQ").choices == ("", "0", "1")
    assert "125000" in entry("Baudrate").suggestions
    assert entry("SendBufferSize").choices == ()


def test_ok_writes_what_differs_and_nothing_else(registry: RegistryStore) -> None:
    dialog = RegistryDialog("CID1:")
    before = registry.path.read_text()
    assert dialog.ok({"Align": 0, "Baudrate": 1_000_000}) == []
    assert registry.path.read_text() == before
    assert dialog.ok({"Align": 2, "Baudrate": 1_000_000, "SPIDevice": "SPI2:"}) == ["Align", "SPIDevice"]
    assert (registry.get("CID1", "Align"), registry.get("CID1", "SPIDevice")) == (2, "SPI2:")


def test_cancel_writes_nothing(registry: RegistryStore) -> None:
    before = registry.path.read_text()
    RegistryDialog("CID1:").entries()
    assert registry.path.read_text() == before


def test_one_impossible_value_and_nothing_is_written(registry: RegistryStore) -> None:
    before = registry.path.read_text()
    with pytest.raises(BadValue, match="Align"):
        RegistryDialog("CID1:").ok({"Baudrate": 500_000, "Align": 9})
    assert registry.path.read_text() == before


def test_new_values_count_when_the_driver_is_loaded_anew(bench: Bench) -> None:
    program = CanCheck()
    program.start(bench.hub, "CID1:")
    RegistryDialog("CID1:").ok({"Align": 2, "Baudrate": 125_000})
    assert (program.port.align, program.port.shown().rate) == (0, 1_000_000)
    program.leave()
    program.start(bench.hub, "CID1:")
    assert program.port.align == 0  # the board was not restarted
    program.leave()
    unload(bench.hub, "CID1:")
    program.start(bench.hub, "CID1:")
    assert (program.port.align, program.port.shown().rate) == (2, 125_000)
    program.leave()


def test_each_port_has_its_own(registry: RegistryStore) -> None:
    registry.install("CID2")
    RegistryDialog("CID2:").ok({"Align": 3})
    assert ports() == ["CID1:", "CID2:"]
    assert (registry.get("CID1", "Align"), registry.get("CID2", "Align")) == (0, 3)
    with pytest.raises(BadValue, match="CID7: is not registered"):
        RegistryDialog("CID7:").entries()
