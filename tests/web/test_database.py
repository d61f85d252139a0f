"""Names and signals by a DBC file, in the server and in the page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import BadDescription, BadSignals, Frame, load_database
from canwire.web.database import Database
from tests.hubs import LONG_S
from tests.web.conftest import at, holds, served_site, somebody, tab
from tests.web.test_send import receiving
from tests.web.trace.watching import sender, tab_on_trace

pytest.importorskip("cantools")
if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.conforms("PG-02")
DBC = """VERSION ""
BU_: ECU
BO_ 291 EngineData: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
 SG_ Hot : 16|1@1+ (1,0) [0|1] "" ECU
BO_ 2566834688 Far: 2 ECU
 SG_ Level : 0|8@1- (1,0) [0|0] "" ECU
BO_ 512 Pages: 2 ECU
 SG_ Page M : 0|4@1+ (1,0) [0|15] "" ECU
 SG_ Near m0 : 8|8@1+ (1,0) [0|100] "" ECU
 SG_ Wide m1 : 8|8@1+ (1,0) [0|200] "" ECU
VAL_ 291 Hot 1 "yes" 0 "no" ;
"""


@pytest.fixture
def dbc(tmp_path: Path) -> Path:
    path = tmp_path / "car.dbc"
    path.write_text(DBC)
    return path


def test_names_by_identifier_and_format(dbc: Path) -> None:
    assert Database([load_database(dbc)]).names == {"123": "EngineData", "18FECA00": "Far", "200": "Pages"}


def test_signals_are_scaled_and_named(dbc: Path) -> None:
    signals = Database([load_database(dbc)]).signals(Frame(0x123, bytes.fromhex("A00F010000000000")))
    assert [(one.name, one.value, one.unit) for one in signals] == [
        ("Speed", "1000", "rpm"),
        ("Hot", "yes", ""),
    ]


@pytest.mark.parametrize(
    "frame", [Frame(0x124), Frame(0x123, extended=True), Frame(0x123, remote=True, dlc=8), Frame(0x123)]
)
def test_what_the_file_does_not_know_or_fit_has_no_signals(dbc: Path, frame: Frame) -> None:
    assert Database([load_database(dbc)]).signals(frame) == []


def test_what_was_encoded_is_decoded(dbc: Path) -> None:
    database = Database([load_database(dbc)])
    frame = database.encode("EngineData", {"Speed": "1000", "Hot": "yes"})
    assert frame == Frame(0x123, bytes.fromhex("A00F010000000000"))
    assert {one.name: one.value for one in database.signals(frame)} == {"Speed": "1000", "Hot": "yes"}
    assert database.encode("Far", {"Level": "-3"}) == Frame(0x18FECA00, b"\xfd\x00", extended=True)


@pytest.mark.parametrize(
    ("values", "faults"),
    [
        ({"Speed": "16001"}, {"Speed"}),
        ({"Speed": "-1", "Hot": "maybe"}, {"Speed", "Hot"}),
        ({"Speed": "nan"}, {"Speed"}),
        ({"Speed": "1e9"}, {"Speed"}),
    ],
)
def test_values_that_do_not_fit_are_named(dbc: Path, values: dict[str, str], faults: set[str]) -> None:
    with pytest.raises(BadSignals) as bad:
        Database([load_database(dbc)]).encode("EngineData", values)
    assert set(bad.value.faults) == faults


def test_only_what_the_multiplexer_chooses_is_encoded(dbc: Path) -> None:
    database = Database([load_database(dbc)])
    assert database.encode("Pages", {"Page": "1", "Near": "0", "Wide": "200"}) == Frame(0x200, b"\x01\xc8")
    with pytest.raises(BadSignals) as bad:
        database.encode("Pages", {"Page": "7", "Near": "0", "Wide": "200"})
    assert set(bad.value.faults) == {"Page"}


def test_a_file_that_is_no_description_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "car.dbc"
    path.write_bytes(b"\xff\xfe\x00BO_ what")
    with pytest.raises(BadDescription, match=r"car\.dbc"):
        load_database(path)


def test_without_a_file_nothing_has_a_name() -> None:
    database = Database()
    assert (database.names, database.signals(Frame(1)), database.messages()) == ({}, [], [])


def test_an_opened_row_shows_its_signals(hub_address: str, dbc: Path) -> None:
    record = canwire.frames_to_array([Frame(0x123, bytes.fromhex("A00F010000000000"))]).tobytes().hex()
    with served_site(hub_address, [str(dbc)]) as site, somebody(site) as client:
        shown = client.get("/trace/row", params={"record": record}).text
    assert "EngineData" in shown
    assert "rpm" in shown


def test_a_row_by_its_signals_in_the_browser(
    browser: Browser, hub_address: str, hub: canwire.Hub, dbc: Path
) -> None:
    with (
        receiving(hub) as channel,
        served_site(hub_address, [str(dbc)]) as site,
        tab(browser, at(site, "send")) as page,
    ):
        page.get_by_role("button", name="New").click()
        page.get_by_label("Message").select_option("EngineData")
        page.get_by_label("Speed, rpm").fill("99999")
        page.get_by_label("Hot").fill("yes")
        page.get_by_role("button", name="Keep").click()
        page.get_by_text("Possible: 0 – 16000.").wait_for()
        page.get_by_label("Speed, rpm").fill("1000")
        page.get_by_role("button", name="Keep").click()
        page.get_by_role("button", name="Send 1").click()
        assert channel.receive(LONG_S) == Frame(0x123, bytes.fromhex("A00F010000000000"))
        page.get_by_role("button", name="Edit 1").click()
        holds(page.get_by_label("Speed, rpm"), "1000")  # it opens as what it was made of


def test_names_in_the_page_s_rows_and_filter(
    browser: Browser, hub_address: str, hub: canwire.Hub, dbc: Path
) -> None:
    with (
        served_site(hub_address, [str(dbc)]) as site,
        sender(hub) as channel,
        tab_on_trace(browser, site, canwire.find_lines(hub, "can0")[0].address) as page,
    ):
        channel.send(Frame(0x123, bytes(8)), timeout=LONG_S)
        channel.send(Frame(0x124, bytes(8)), timeout=LONG_S)
        page.locator("#body .trace-row", has_text="EngineData").wait_for()
        page.locator("#body .trace-row .c-id", has_text="124").wait_for()  # a time may have these digits, too
        page.locator("#filter").fill("enginedata")
        page.locator("#filter").press("Enter")
        page.locator("#shown", has_text="1").wait_for()
