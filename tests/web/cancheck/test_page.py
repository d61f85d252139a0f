"""CanCheck's page: its main window and registry dialog, its viewers, what it refuses, a hub or board that goes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import Frame
from canwire.candrv import RegistryStore
from tests.candrv.bench import Peer
from tests.candrv.conftest import CONFIG
from tests.hubs import serving
from tests.web.cancheck.conftest import BOARD, panel, started
from tests.web.conftest import at, counts, holds, nameless_controls, served_site, tab

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Page

    from canwire.web.server import Site


@pytest.mark.finding("page 18")
@pytest.mark.conforms("FT-06")
def test_the_main_window(cancheck: Page, hub: canwire.Hub, peer: Peer) -> None:
    board = hub.board(BOARD).id

    def rate() -> int:
        mode = hub.line_status(board, 0).mode
        assert mode is not None
        assert mode.timing is not None
        return mode.timing.bit_rate

    cancheck.get_by_text("CAN Port CID1:", exact=True).wait_for()
    field = cancheck.get_by_label("Baud rate, bit/s")
    holds(field, "1000000")
    for wrong in ("fast", "0", "-1", "1000001", ""):
        field.fill(wrong)
        cancheck.get_by_role("button", name="Set", exact=True).click()
        cancheck.locator("#rate-form .fault").wait_for()
        assert rate() == 1_000_000
    field.fill("999983")  # no divider gives this one
    cancheck.get_by_role("button", name="Set", exact=True).click()
    holds(field, "1000000")
    assert rate() == 1_000_000
    field.fill("250000")
    cancheck.get_by_role("button", name="Set", exact=True).click()
    cancheck.get_by_text("The baud rate is 250000 bit/s.").wait_for()
    assert rate() == 250_000
    cancheck.get_by_label("CAN mode").select_option("1")
    cancheck.get_by_text("CAN 2.0B is set.").wait_for()
    cancheck.get_by_label("Frame format").select_option("2")
    cancheck.get_by_text("The frame format is set.").wait_for()
    holds(cancheck.get_by_label("CAN mode"), "1")
    cancheck.get_by_role("button", name="LISTEN_ON").click()
    cancheck.get_by_text("LISTEN_ON was sent to the port.").wait_for()
    mode = hub.line_status(board, 0).mode
    assert mode is not None
    assert mode.listen_only
    cancheck.get_by_role("button", name="Switch").click()
    cancheck.get_by_text("CanCheck is on CID1:.").wait_for()


@pytest.mark.conforms("FT-06")
def test_windows_until_the_channels_run_out_and_leaving(cancheck: Page) -> None:
    cancheck.get_by_role("button", name="Send & Receive").click()
    panel(cancheck, "send")
    panel(cancheck, "receive")
    counts(cancheck.get_by_text("CID1: · handle 0x100"), 2)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    counts(cancheck.locator(".window"), 3)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    cancheck.get_by_text("ERROR_NO_SYSTEM_RESOURCES (1450)").wait_for()
    counts(cancheck.locator(".window"), 3)
    cancheck.get_by_role("button", name="Close handle 100").first.click()
    cancheck.locator('[data-key="receive-100"]').wait_for(state="detached")
    counts(cancheck.locator(".window"), 1)
    cancheck.get_by_role("button", name="Leave CanCheck").click()
    cancheck.locator(".window").wait_for(state="detached")
    cancheck.get_by_role("button", name="Restart the board").click()
    cancheck.get_by_text("The next program that opens CID1: reads the registry again.").wait_for()


@pytest.mark.conforms("FT-07")
def test_the_registry_dialog(cancheck: Page, registry: RegistryStore) -> None:
    before = registry.path.read_text()
    cancheck.get_by_role("button", name="Set Registry").click()
    dialog = cancheck.locator("#registry-dialog")
    holds(dialog.get_by_label("AcceptanceMask (hex)"), "00000000")
    dialog.get_by_text("They take effect once the board has been restarted").wait_for()
    dialog.get_by_label("Align").select_option("2")
    dialog.get_by_role("button", name="Cancel").click()
    assert registry.path.read_text() == before
    cancheck.get_by_role("button", name="Set Registry").click()
    holds(dialog.get_by_label("Align"), "0")
    dialog.get_by_label("Align").select_option("2")
    dialog.get_by_label("AcceptanceMask (hex)").fill("xyz")
    dialog.get_by_role("button", name="OK").click()
    dialog.get_by_text("“xyz” is not a hexadecimal number").wait_for()
    assert registry.path.read_text() == before
    dialog.get_by_label("AcceptanceMask (hex)").fill("FFFFFFFF")
    dialog.get_by_role("button", name="OK").click()
    cancheck.get_by_text("Written: AcceptanceMask, Align.").wait_for()
    assert (registry.get("CID1", "Align"), registry.get("CID1", "AcceptanceMask")) == (2, 0xFFFFFFFF)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    holds(panel(cancheck, "receive").get_by_label("Mask", exact=True), "00000000")


@pytest.mark.conforms("FT-06")
def test_wrong_fields_are_refused_and_nothing_is_done(site: Site, client: httpx.Client, peer: Peer) -> None:
    def post(name: str, **fields: str) -> tuple[int, set[str]]:
        answer = client.post(f"/cancheck/{name}", data=fields)
        return answer.status_code, set(answer.json()["faults"])

    assert post("rate", rate="500000") == (409, set())  # it is not running
    assert post("start", port="CID9:") == (422, {"port"})
    assert post("start", port="CID1:") == (200, set())
    assert post("mode", mode="2") == (422, {"mode"})
    assert post("format", format="3") == (422, {"format"})
    assert post("command", number="99") == (409, set())
    assert post("open", kind="all") == (422, {"kind"})
    assert post("open", kind="both") == (200, set())
    assert post("toggle", number="100", event="4096") == (422, {"event"})
    assert post("toggle", number="100", event="3") == (409, set())
    assert post("filter", number="100", code="1FFFFFFFF", mask="") == (422, {"code", "mask"})
    assert post("filter", number="999", code="0", mask="0") == (409, set())
    assert post("open-log", number="100", kind="send", file=".hidden") == (422, {"file"})
    assert post("open-log", number="100", kind="send", file="") == (422, {"file"})
    good = {"number": "100", "dlc": "0", "id": "1", "delay": "1", "state": "active"}
    for field, value in [("dlc", "9"), ("id", "-1"), ("delay", "1.5"), ("state", "on"), ("ext", "on")]:
        assert post("generator", **{**good, field: value}) == (422, {field})
    assert post("generator", **good, range="on") == (422, {"idto"})
    assert post("edit", number="100", index="0") == (409, set())
    assert peer.receive(0.1) is None


@pytest.mark.conforms("PG-01")
def test_viewers_see_the_windows_and_can_do_nothing(
    client: httpx.Client, viewer: httpx.Client, peer: Peer
) -> None:
    client.post("/cancheck/start", data={"port": "CID1:"})
    client.post("/cancheck/open", data={"kind": "receive"})
    assert "Receive" in viewer.get("/cancheck/window?number=100&kind=receive").text
    assert viewer.post("/cancheck/open", data={"kind": "receive"}).status_code == 403
    assert viewer.get("/cancheck/window?number=xyz&kind=receive").status_code == 404


@pytest.mark.conforms("PG-01")
def test_several_viewers_see_the_same_and_readers_can_press_nothing(
    cancheck: Page, browser: Browser, site: Site, peer: Peer
) -> None:
    cancheck.get_by_role("button", name="Send & Receive").click()
    box = panel(cancheck, "receive")
    box.get_by_label("Mask", exact=True).fill("FFFFFFFF")
    box.get_by_role("button", name="Set Filter").click()
    cancheck.get_by_text("The filter is code 0x00000000").wait_for()
    with tab(browser, f"{site.url}cancheck") as reader:
        panel(reader, "send")
        peer.send(Frame(0x123, b"\xab"))
        for one in (cancheck, reader):
            panel(one, "receive").locator("tbody tr", has_text="AB").wait_for()
        assert [one.inner_text() for one in reader.locator(".window button:enabled").all()] == [
            "Hide Column Headers",
            "Hide Column Headers",
        ]


@pytest.mark.conforms("PG-13")
def test_windows_fit_and_every_control_has_a_name(browser: Browser, site: Site, client: httpx.Client) -> None:
    assert client.post("/cancheck/start", data={"port": "CID1:"}).status_code == 200
    assert client.post("/cancheck/open", data={"kind": "both"}).status_code == 200
    with tab(browser, at(site, "cancheck"), locale="de-DE") as page:
        panel(page, "receive")
        panel(page, "send").get_by_role("button", name="Neu").click()
        page.get_by_label("Bereich").check()
        dialog = page.locator("#generator-dialog")
        for width in (1280, 480):
            page.set_viewport_size({"width": width, "height": 800})
            assert page.locator("html").evaluate("one => one.scrollWidth") <= width
            assert dialog.evaluate("one => one.scrollWidth <= one.clientWidth"), width
        assert nameless_controls(page) == []


@pytest.mark.conforms("FT-06")
def test_when_the_hub_is_lost_cancheck_has_ended(browser: Browser, tmp_path: Path) -> None:
    with (
        serving(tmp_path, CONFIG) as served,
        served_site(served.address) as site,
        tab(browser, at(site, "cancheck")) as page,
    ):
        started(page)
        page.get_by_role("button", name="Send & Receive").click()
        panel(page, "receive")
        served.process.terminate()
        page.locator(".window").first.wait_for(state="detached")
        page.get_by_role("button", name="Start", exact=True).wait_for()


@pytest.mark.conforms("FT-06")
def test_a_board_that_is_pulled_out_is_told_in_every_window(cancheck: Page, hub: canwire.Hub) -> None:
    cancheck.get_by_role("button", name="Send & Receive").click()
    panel(cancheck, "receive")
    panel(cancheck, "send")
    hub.unplug(BOARD)
    for place in ("#trouble", "[data-key=send-100] [data-trouble]", "[data-key=receive-100] [data-trouble]"):
        cancheck.locator(place, has_text="unplugged").wait_for()
    cancheck.get_by_role("button", name="Leave CanCheck").click()
    cancheck.get_by_role("button", name="Start", exact=True).click()
    cancheck.locator("#status", has_text="ERROR_FILE_NOT_FOUND").wait_for()
