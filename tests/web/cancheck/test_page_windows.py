"""CanCheck's windows in the browser: every dialog is clicked through, and the manual's examples reach the bus."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from canwire import Frame
from tests.candrv.bench import Peer
from tests.web.cancheck.conftest import panel
from tests.web.conftest import counts, holds

if TYPE_CHECKING:
    from playwright.sync_api import Page


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


@pytest.mark.conforms("FT-08")
@pytest.mark.conforms("FT-09")
@pytest.mark.conforms("FT-10")
@pytest.mark.conforms("FT-11")
def test_the_receive_window(
    cancheck: Page, peer: Peer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cancheck.get_by_role("button", name="Receive", exact=True).click()
    box = panel(cancheck, "receive")
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
    counts(row.get_by_role("img", name="RECEIVED"), 1)

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
    box = panel(cancheck, "send")
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
    box, dialog = panel(cancheck, "send"), cancheck.locator("#generator-dialog")
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
    dialog.get_by_text("“1G” is not a hexadecimal number").wait_for()
    counts(dialog.locator(".fault"), 3)
    counts(box.locator("tr[data-index]"), 0)
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
    dialog.wait_for()
    holds(dialog.get_by_label("ID", exact=True), "123")
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
    counts(heads, 2)
    box.get_by_role("button", name="Hide Column Headers").click()
    counts(heads, 0)
    box.get_by_role("button", name="Abort Transmission").click()
    cancheck.get_by_text("Aborted: 0 messages were given up.").wait_for()
    box.get_by_role("button", name="New").click()
    dialog.get_by_role("button", name="Cancel").click()
    counts(box.locator("tr[data-index]"), 1)
