"""The boards' view: what it shows, and what can be done there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import canwire

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Page

pytestmark = pytest.mark.conforms("PG-01")


def test_every_board_and_line_is_in_the_tree(client: httpx.Client, hub: canwire.Hub) -> None:
    tree = client.get("/boards/tree").text
    for place in canwire.every_line(hub):
        assert f'data-line="{place.address}"' in tree
        assert place.board.description in tree


def test_a_line_is_started_at_a_rate_and_stopped(client: httpx.Client, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "can0")[0]
    answer = client.post("/boards/up", data={"line": place.address, "rate": "250000"})
    assert answer.status_code == 200, answer.text
    status = place.status(hub)
    assert status.running
    assert status.mode is not None
    assert status.mode.timing is not None
    assert status.mode.timing.bit_rate == 250_000
    assert client.post("/boards/stop", data={"line": place.address}).status_code == 200
    assert not place.status(hub).running


@pytest.mark.parametrize("rate", ["", "fast", "0", "-5", "1000001", "1e5", "99999999999999", "7"])
def test_a_wrong_rate_is_told_at_its_field_and_nothing_is_done(asker: httpx.Client, rate: str) -> None:
    before = asker.get("/boards/tree").text
    answer = asker.post("/boards/up", data={"line": "HW000001:0", "rate": rate})
    assert answer.status_code == 422
    assert set(answer.json()["faults"]) == {"rate"}
    assert asker.get("/boards/tree").text == before
    assert "not initialised" in before


def test_plug_and_unplug(client: httpx.Client, hub: canwire.Hub) -> None:
    before = {board.hardware_id for board in hub.boards()}
    answer = client.post("/boards/plug", data={"kind": "usb-to-can", "serial": "HW777777"})
    assert answer.status_code == 200, answer.text
    assert {board.hardware_id for board in hub.boards()} == before | {"HW777777"}
    assert client.post("/boards/unplug", data={"board": "HW777777"}).status_code == 200
    assert {board.hardware_id for board in hub.boards()} == before


def test_what_the_hub_refuses_is_shown_in_its_words(client: httpx.Client, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "can0")[0]
    with hub.open_control(place.board.id, place.line):
        answer = client.post("/boards/stop", data={"line": place.address})
    assert answer.status_code == 409
    assert "test" in answer.json()["message"]  # the holder's name


def test_registers_of_every_chip_that_has_some(client: httpx.Client, hub: canwire.Hub) -> None:
    shown = client.get("/boards/registers").text
    chips = [place for place in canwire.every_line(hub, "CAN") if hub.registers(place.board.id, place.line)]
    assert len(chips) >= 2  # an SJA1000 and an MCP2515
    for place in chips:
        assert f'data-chip="{place.address}"' in shown


def test_up_in_the_browser_by_keyboard(page: Page, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "can0")[0]
    page.locator(f'[id="up-{place.address}"]').press("Enter")
    rate = page.get_by_label("Bit rate, bit/s", exact=True)
    rate.fill("many")
    rate.press("Enter")
    page.get_by_text("“many” is no number").wait_for()
    assert rate.get_attribute("aria-invalid") == "true"
    assert not place.status(hub).initialised
    rate.fill("125000")
    rate.press("Enter")
    page.get_by_text(f"{place.address} runs at 125000 bit/s").wait_for()
    page.locator(f'tr[data-line="{place.address}"] .state.error-active').wait_for()
    assert place.status(hub).running


def test_changed_register_bits_are_marked(page: Page, hub: canwire.Hub) -> None:
    place = next(place for place in canwire.every_line(hub) if place.board.kind == "inducan104")
    chip = page.locator(f'[data-chip="{place.address}"]')
    chip.locator("summary").click()
    assert chip.locator("b.changed").count() == 0
    mode = canwire.WantedMode(500_000).mode(place.info.capabilities)
    with canwire.start_line(hub, place, mode):
        chip.locator('tr[data-register="MOD"] b.changed').first.wait_for()
    assert page.locator(f'[data-chip="{place.address}"]').get_attribute("open") is not None
