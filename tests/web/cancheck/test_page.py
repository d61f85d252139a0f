"""CanCheck in the browser: every dialog is clicked through, and the manual's examples reach the bus."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import Frame
from canwire.candrv import RegistryStore
from tests.candrv.bench import Peer
from tests.candrv.conftest import CONFIG
from tests.hubs import Served, serving
from tests.web.cancheck.conftest import BOARD

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Locator, Page

    from canwire.web.server import Site


@pytest.fixture
def hub_served(home: Path) -> Iterator[Served]:
    """In fast time, with the boards of CANDRV's tests."""
    with serving(home, CONFIG) as made:
        yield made


@pytest.fixture
def peer(hub: canwire.Hub) -> Iterator[Peer]:
    with closing(Peer(hub)) as made:
        yield made


@pytest.fixture
def cancheck(page: Page, peer: Peer) -> Page:
    """Started on CID1:, in a tab."""
    page.get_by_role("link", name="CanCheck").click()
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_role("heading", name="CanCheck", exact=True).wait_for()
    page.get_by_role("button", name="ENTER_STANDBY").wait_for()
    return page


def window(page: Page, kind: str) -> Locator:
    found = page.locator(f".window[data-kind={kind}]").first
    found.wait_for()
    return found


def fill_example(page: Page, *, repeat: bool) -> None:
    """The manual's, but for the delay: the page's hub keeps to the clock while nothing is sent."""
    dialog = page.locator("#generator-dialog")
    dialog.get_by_label("EXT").check()
    dialog.get_by_label("Use Range").check()
    dialog.get_by_label("Data Byte(s) (DLC)").fill("3")
    dialog.get_by_label("ID", exact=True).fill("025E0235")
    dialog.get_by_label("ID, to").fill("025E0235")
    for place, (first, last) in enumerate([("00", "11"), ("11", "22"), ("33", "00")]):
        dialog.get_by_label(f"Byte {place}", exact=True).fill(first)
        dialog.get_by_label(f"Byte {place}, to").fill(last)
    dialog.get_by_label("Delay, ms").fill("5")
    dialog.get_by_label("Wrap").check()
    dialog.get_by_label("Repeat").set_checked(repeat)


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
    assert field.input_value() == "1000000"
    for wrong in ("fast", "0", "-1", "1000001", ""):
        field.fill(wrong)
        cancheck.get_by_role("button", name="Set", exact=True).click()
        cancheck.locator("#rate-form .fault").wait_for()
        assert rate() == 1_000_000
    field.fill("250000")
    cancheck.get_by_role("button", name="Set", exact=True).click()
    cancheck.get_by_text("The baud rate is 250000 bit/s.").wait_for()
    assert rate() == 250_000
    cancheck.get_by_label("CAN mode").select_option("1")
    cancheck.get_by_text("CAN 2.0B is set.").wait_for()
    cancheck.get_by_label("Frame format").select_option("2")
    cancheck.get_by_text("The frame format is set.").wait_for()
    assert cancheck.get_by_label("CAN mode").input_value() == "1"
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
    window(cancheck, "send")
    window(cancheck, "receive")
    assert cancheck.get_by_text("CID1: · handle 0x100").count() == 2
    for _ in range(2):
        cancheck.get_by_role("button", name="Receive", exact=True).click()
    cancheck.get_by_text("ERROR_NO_SYSTEM_RESOURCES (1450)").wait_for()
    assert cancheck.locator(".window").count() == 3
    cancheck.get_by_role("button", name="Close handle 100").first.click()
    cancheck.locator('[data-key="receive-100"]').wait_for(state="detached")
    assert cancheck.locator(".window").count() == 1
    cancheck.get_by_role("button", name="Leave CanCheck").click()
    cancheck.locator(".window").wait_for(state="detached")
    cancheck.get_by_role("button", name="Restart the board").click()
    cancheck.get_by_text("The next program that opens CID1: reads the registry anew.").wait_for()


@pytest.mark.conforms("FT-07")
def test_the_registry_dialog(cancheck: Page, registry: RegistryStore) -> None:
    before = registry.path.read_text()
    cancheck.get_by_role("button", name="Set Registry").click()
    dialog = cancheck.locator("#registry-dialog")
    assert dialog.get_by_label("AcceptanceMask (hex)").input_value() == "00000000"
    dialog.get_by_text("They count once the board has been restarted").wait_for()
    dialog.get_by_label("Align").select_option("2")
    dialog.get_by_role("button", name="Cancel").click()
    assert registry.path.read_text() == before
    cancheck.get_by_role("button", name="Set Registry").click()
    assert dialog.get_by_label("Align").input_value() == "0"
    dialog.get_by_label("Align").select_option("2")
    dialog.get_by_label("AcceptanceMask (hex)").fill("xyz")
    dialog.get_by_role("button", name="OK").click()
    dialog.get_by_text("“xyz” is no hexadecimal number").wait_for()
    assert registry.path.read_text() == before
    dialog.get_by_label("AcceptanceMask (hex)").fill("FFFFFFFF")
    dialog.get_by_role("button", name="OK").click()
    cancheck.get_by_text("Written: AcceptanceMask, Align.").wait_for()
    assert (registry.get("CID1", "Align"), registry.get("CID1", "AcceptanceMask")) == (2, 0xFFFFFFFF)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    assert window(cancheck, "receive").get_by_label("Mask", exact=True).input_value() == "00000000"


@pytest.mark.conforms("FT-08")
@pytest.mark.conforms("FT-09")
@pytest.mark.conforms("FT-10")
@pytest.mark.conforms("FT-11")
def test_the_receive_window(
    cancheck: Page, peer: Peer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    box = window(cancheck, "receive")
    box.get_by_text("none in CAN 2.0A").wait_for()
    box.get_by_label("Mask", exact=True).fill("FFFFFFFFF")
    box.get_by_role("button", name="Set Filter").click()
    box.locator(".fault").wait_for()
    assert "0x00000000" in box.locator("[data-filter]").inner_text()
    box.get_by_label("Mask", exact=True).fill("FFFFFFFF")
    box.get_by_role("button", name="Set Filter").click()
    box.get_by_text("+++ ++++ ++++ · ++++ ++++ ++++ ++++").wait_for()

    peer.send(Frame(0x123, b"\xab\xcd"))
    row = box.locator("tbody tr", has_text="AB CD")
    row.wait_for()
    assert row.locator("td").all_inner_texts()[1:] == ["0", "STD", "00000123", "0", "2", "AB CD"]
    assert row.get_by_role("img", name="RECEIVED").count() == 1

    box.get_by_role("button", name="Open Logfile").click()
    dialog = cancheck.locator("#log-dialog")
    dialog.get_by_label("File name").fill("../x")
    dialog.get_by_role("button", name="Open", exact=True).click()
    dialog.get_by_text("no directories").wait_for()
    dialog.get_by_label("File name").fill("events.txt")
    dialog.get_by_role("button", name="Open", exact=True).click()
    box.get_by_text("log: events.txt").wait_for()
    box.get_by_role("button", name="Clear Events").click()
    row.wait_for(state="detached")
    peer.send(Frame(0x124, b"\xef"))
    box.locator("tbody tr", has_text="EF").wait_for()
    box.get_by_role("button", name="Close Logfile").click()
    box.get_by_role("button", name="Open Logfile").wait_for()
    assert "\t00000124\t" in (tmp_path / "events.txt").read_text()

    head = box.locator("thead")
    box.get_by_role("button", name="Hide Column Headers").click()
    head.wait_for(state="hidden")
    box.get_by_role("button", name="Hide Column Headers").click()
    head.wait_for()
    box.get_by_role("button", name="RECEIVED", exact=True).click()
    box.get_by_text("0x7FE").wait_for()
    assert box.get_by_role("button", name="RECEIVED", exact=True).get_attribute("aria-pressed") == "false"
    box.get_by_role("button", name="None").click()
    box.get_by_text("0x000", exact=True).wait_for()
    box.get_by_role("button", name="All").click()
    box.get_by_text("0x7FF").wait_for()
    box.get_by_role("button", name="Overrun", exact=True).click()
    cancheck.get_by_text("CANBUS_CMD_CLEAR_OVERRUN was sent.").wait_for()


@pytest.mark.conforms("FT-12")
@pytest.mark.conforms("FT-13")
@pytest.mark.conforms("FT-16")
@pytest.mark.conforms("FT-18")
def test_the_examples_in_the_page_with_the_frames_counted_on_the_bus(cancheck: Page, peer: Peer) -> None:
    cancheck.get_by_label("CAN mode").select_option("1")
    cancheck.get_by_text("CAN 2.0B is set.").wait_for()
    cancheck.get_by_role("button", name="Send", exact=True).click()
    box = window(cancheck, "send")
    box.get_by_role("button", name="New").click()
    fill_example(cancheck, repeat=True)
    cancheck.locator("#generator-dialog").get_by_role("button", name="Activate").click()
    data = [frame.data.hex(" ").upper() for frame in peer.received(60)]
    box.get_by_role("button", name="Pause All").click()
    box.get_by_text("-Paused-").wait_for()
    assert [data[number - 1] for number in (1, 18, 19, 52, 53)] == [
        "00 11 33",
        "11 22 22",
        "00 11 21",
        "0F 20 00",
        "10 21 33",
    ]
    while peer.receive(0.1) is not None:  # what was sent until it was paused
        pass
    box.get_by_role("button", name="New").click()
    fill_example(cancheck, repeat=False)
    cancheck.locator("#generator-dialog").get_by_role("button", name="Activate").click()
    box.locator('tr[data-index="1"]', has_text="-Paused-").wait_for()
    second = peer.received(52)
    assert peer.receive(0.3) is None
    assert [frame.data.hex(" ").upper() for frame in second] == data[:52]
    assert {(frame.id, frame.extended) for frame in second} == {(0x025E0235, True)}
    sent = box.locator("[data-list] tbody tr", has=cancheck.get_by_role("cell", name="1", exact=True))
    sent.filter(has_text="0F 20 00").wait_for()


@pytest.mark.conforms("FT-14")
@pytest.mark.conforms("FT-17")
def test_the_generators_window(cancheck: Page, peer: Peer) -> None:
    cancheck.get_by_role("button", name="Send", exact=True).click()
    box, dialog = window(cancheck, "send"), cancheck.locator("#generator-dialog")
    box.get_by_role("button", name="New").click()
    assert dialog.get_by_label("EXT").is_disabled()  # CAN 2.0A
    assert dialog.get_by_label("Wrap").is_hidden()
    dialog.get_by_label("Data Byte(s) (DLC)").fill("2")
    assert [dialog.get_by_label(f"Byte {place}", exact=True).is_enabled() for place in (1, 2)] == [
        True,
        False,
    ]
    dialog.get_by_label("ID", exact=True).fill("800")
    dialog.get_by_label("Byte 0", exact=True).fill("1G")
    dialog.get_by_label("Delay, ms").fill("A")
    dialog.get_by_role("button", name="Activate").click()
    dialog.get_by_text("“1G” is no hexadecimal number").wait_for()
    assert dialog.locator(".fault").count() == 3
    assert box.locator("tr[data-index]").count() == 0
    dialog.get_by_label("ID", exact=True).fill("123")
    dialog.get_by_label("Byte 0", exact=True).fill("1F")
    dialog.get_by_label("Delay, ms").fill("3600000")
    dialog.get_by_role("button", name="Pause").click()
    row = box.locator('tr[data-index="0"]')
    row.get_by_text("-Paused-").wait_for()
    assert peer.receive(0.1) is None

    row.click()
    box.get_by_label("Activate", exact=True).check()
    assert peer.receive() == Frame(0x123, b"\x1f\x00")
    row.get_by_text("-Paused-").wait_for(state="detached")
    box.get_by_role("button", name="Edit").click()
    assert dialog.get_by_label("ID", exact=True).input_value() == "123"
    row.get_by_text("-Paused-").wait_for()
    cancheck.keyboard.press("Escape")
    row.get_by_text("-Paused-").wait_for(state="detached")
    box.get_by_role("button", name="Edit").click()
    dialog.get_by_label("RTR").check()
    dialog.get_by_role("button", name="Activate").click()
    assert peer.receive() == Frame(0x123, remote=True, dlc=2)
    box.get_by_role("button", name="Pause All").click()
    row.get_by_text("-Paused-").wait_for()
    box.get_by_role("button", name="Activate All").click()
    assert peer.receive() == Frame(0x123, remote=True, dlc=2)
    heads = box.locator("thead:visible")
    assert heads.count() == 2
    box.get_by_role("button", name="Hide Column Headers").click()
    assert heads.count() == 0
    box.get_by_role("button", name="Abort Transmission").click()
    cancheck.get_by_text("Aborted: 0 messages were given up.").wait_for()
    box.get_by_role("button", name="New").click()
    dialog.get_by_role("button", name="Cancel").click()
    assert box.locator("tr[data-index]").count() == 1


@pytest.mark.conforms("PG-11")
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


@pytest.mark.conforms("PG-12")
def test_when_the_hub_is_lost_cancheck_has_ended(cancheck: Page, hub_served: Served) -> None:
    cancheck.get_by_role("button", name="Send & Receive").click()
    window(cancheck, "receive")
    hub_served.process.terminate()
    cancheck.locator(".window").first.wait_for(state="detached")
    cancheck.get_by_role("button", name="Start", exact=True).wait_for()


@pytest.mark.conforms("PG-12")
def test_a_board_that_is_pulled_out_is_told_in_every_window(cancheck: Page, hub: canwire.Hub) -> None:
    cancheck.get_by_role("button", name="Send & Receive").click()
    window(cancheck, "receive")
    window(cancheck, "send")
    hub.unplug(BOARD)
    for place in ("#trouble", "[data-key=send-100] [data-trouble]", "[data-key=receive-100] [data-trouble]"):
        cancheck.locator(place, has_text="unplugged").wait_for()
    cancheck.get_by_role("button", name="Leave CanCheck").click()
    cancheck.get_by_role("button", name="Start", exact=True).click()
    cancheck.locator("#status", has_text="ERROR_FILE_NOT_FOUND").wait_for()
