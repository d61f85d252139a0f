"""The boards' view: what it shows, and what can be done there."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire.web.boards.leds import Leds, leds_of
from canwire.web.lines import Line, lateness_of, look
from tests.cases import each
from tests.hubs import LONG_S, served_here
from tests.web.conftest import counts, served_site, somebody
from tests.web.trace.watching import watching

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Page

pytestmark = pytest.mark.conforms("PG-01")


@pytest.mark.finding("page A6")
def test_every_board_and_line_is_in_the_tree(client: httpx.Client, hub: canwire.Hub) -> None:
    tree = client.get("/boards/tree").text
    for place in canwire.every_line(hub):
        assert f'data-line="{place.address}"' in tree
        assert place.board.description in tree
    assert set(re.findall(r'data-label="TEC">(.+?)</td>', tree)) == {"–"}  # nothing is initialised yet


def test_buses_that_cannot_keep_up_are_told_once(
    client: httpx.Client, hub: canwire.Hub, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = look(hub)
    assert lateness_of(lines) == []
    assert "behind the clock" not in client.get("/boards/tree").text
    late = [
        line._replace(can=replace(line.can, behind_ns=2 * 10**9)) for line in lines if line.can is not None
    ]
    late += [
        line._replace(lin=line.lin._replace(status=replace(line.lin.status, behind_ns=2 * 10**9)))
        for line in lines
        if line.lin is not None
    ]
    assert {line.can is None for line in late} == {True, False}
    monkeypatch.setattr("canwire.web.boards.view.look", lambda hub, boards: late)
    for shown in (late, [line for line in late if line.can is None]):
        (said,) = lateness_of(shown)
        assert said.startswith("bus time is 2.00 s behind the clock")
    assert client.get("/boards/tree").text.count("bus time is 2.00 s behind the clock") == 1


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


@each("rate", ["", "fast", "0", "-5", "1000001", "1e5", "99999999999999", "7"])
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


@pytest.mark.conforms("CT-19")
def test_leds_tell_of_traffic_and_errors(client: httpx.Client, hub: canwire.Hub) -> None:
    """A frame that nobody acknowledges: traffic, and errors; then bus-off by bit errors."""
    place = canwire.find_lines(hub, "can0")[0]
    lone = canwire.WantedMode(500_000).mode(place.info.capabilities)
    with (
        canwire.start_line(hub, place, lone),
        hub.open_channel(place.board.id, place.line) as channel,
    ):
        assert leds_of(hub, look_at(hub, place)) == Leds("off", "off", None)
        channel.set_up(canwire.ChannelMode(receive=8, transmit=8))
        channel.activate()
        channel.send(canwire.Frame(0x123))
        await_status(hub, place, lambda status: status.load > 0 and status.tec > 0)
        assert leds_of(hub, look_at(hub, place)) == Leds("lit", "blinking", None)
        with hub.bus("can0").faults.inject("bit", times=None):
            await_status(hub, place, lambda status: status.state == canwire.ErrorState.BUS_OFF)
        assert leds_of(hub, look_at(hub, place)).red == "lit"
        assert "Recover" in client.get("/boards/tree").text
        assert client.post("/boards/recover", data={"line": place.address}).status_code == 200
        await_status(hub, place, lambda status: status.state != canwire.ErrorState.BUS_OFF)


@pytest.mark.conforms("AC-03")
def test_an_interrupt_that_waits_lights_the_yellow_led(hub: canwire.Hub) -> None:
    place = next(place for place in canwire.every_line(hub) if place.board.kind == "inducan104")
    other = canwire.find_lines(hub, "can0")[0]
    idle = next(place for place in canwire.every_line(hub) if place.board.kind == "picocom1")
    assert leds_of(hub, look_at(hub, place)).yellow == "off"  # BasicCAN, before anybody set it up
    with (
        canwire.start_line(hub, place, canwire.WantedMode(500_000).mode(place.info.capabilities)),
        canwire.start_line(hub, other, canwire.WantedMode(500_000).mode(other.info.capabilities)),
        hub.open_channel(other.board.id, other.line) as channel,
    ):
        assert leds_of(hub, look_at(hub, place)).yellow == "off"
        assert leds_of(hub, look_at(hub, idle)).yellow == "off"
        hub.hold_interrupts(place.board.id, place.line)
        channel.set_up(canwire.ChannelMode(receive=8, transmit=8))
        channel.activate()
        channel.send(canwire.Frame(0x123))
        await_status(hub, other, lambda status: status.frames_sent == 1)
        assert leds_of(hub, look_at(hub, place)).yellow == "lit"
        hub.hold_interrupts(place.board.id, place.line, held=False)


def test_a_board_unplugged_since_it_was_looked_at_has_no_interrupt(hub: canwire.Hub) -> None:
    board = hub.plug("inducan104", buses=("can0",), base=0x300, irq=7)
    line = look_at(hub, next(place for place in canwire.every_line(hub) if place.board.id == board.id))
    hub.unplug(board.hardware_id)
    assert leds_of(hub, line) == Leds("off", "off", None)


def look_at(hub: canwire.Hub, place: canwire.LinePlace) -> Line:
    return next(line for line in look(hub) if line.place.address == place.address)


def await_status(
    hub: canwire.Hub, place: canwire.LinePlace, reached: Callable[[canwire.LineStatus], bool]
) -> None:
    """The bus runs in real time; asking is what takes time here."""
    end_s = time.monotonic() + LONG_S
    while not reached(place.status(hub)):
        assert time.monotonic() < end_s, place.status(hub)


def test_plug_and_unplug_in_the_browser(page: Page, hub: canwire.Hub) -> None:
    page.get_by_role("button", name="Plug in").first.click()
    page.get_by_label("Kind").select_option("inducan104")
    page.get_by_label("I/O address").fill("10000")
    page.get_by_label("Interrupt line").fill("x")
    page.locator("#plug-form button.main").click()
    page.get_by_text("10000 is out of range: 0 to FFFF.").wait_for()
    page.get_by_text("“x” is not a number").wait_for()
    page.get_by_label("I/O address").fill("300")
    page.get_by_label("Interrupt line").fill("7")
    page.get_by_label("Hardware id").fill("HW000077")
    page.locator("#plug-form button.main").click()
    page.get_by_text("HW000077 (inducan104) is plugged in.").wait_for()
    board = page.locator('[data-board="HW000077"].board')
    board.get_by_text("IRQ 7").wait_for()
    page.once("dialog", lambda asked: asked.accept())
    board.get_by_role("button", name="Unplug").click()
    page.get_by_text("HW000077 is unplugged.").wait_for()
    board.wait_for(state="detached")
    assert "HW000077" not in {one.hardware_id for one in hub.boards()}


@pytest.mark.parametrize("by", ["mouse", "keyboard"])
def test_a_button_that_is_pressed_while_its_part_is_refreshed_does_what_it_says(page: Page, by: str) -> None:
    button = page.get_by_role("button", name="Start HW000002:0")
    refreshed = re.compile("/boards/tree")
    if by == "mouse":
        button.hover()
        page.mouse.down()
    else:
        button.focus()
        page.keyboard.down("Space")
    for _ in range(2):  # the first one may have been asked for before
        with page.expect_response(refreshed) as answer:
            pass
        answer.value.finished()
    if by == "mouse":
        page.mouse.up()
    else:
        page.keyboard.up("Space")
    page.locator("#up-dialog").wait_for()
    page.locator("#up-dialog [data-closes-dialog]").click()
    with page.expect_response(refreshed):  # afterwards it goes on
        page.evaluate("document.querySelector('#tree .board').id = 'old'")
    page.locator("#old").wait_for(state="detached")


def test_up_in_the_browser_by_keyboard(page: Page, hub: canwire.Hub) -> None:
    place = canwire.find_lines(hub, "can0")[0]
    page.locator(f'[id="up-{place.address}"]').press("Enter")
    rate = page.locator("#up-form [name=rate]")
    rate.fill("many")
    rate.press("Enter")
    page.get_by_text("“many” is not a number").wait_for()
    assert rate.get_attribute("aria-invalid") == "true"
    assert not place.status(hub).initialised
    rate.fill("125000")
    rate.press("Enter")
    page.get_by_text(f"{place.address} runs at 125000 bit/s").wait_for()
    page.locator(f'tr[data-line="{place.address}"] .state.error-active').wait_for()
    assert place.status(hub).running

    lin = canwire.find_lines(hub, "lin0")[0].address
    page.locator(f'[id="up-{lin}"]').press("Enter")
    dialog = page.locator("#lin-up-dialog")
    dialog.locator("[name=rate]").fill("30000")
    dialog.locator("[name=rate]").press("Enter")
    dialog.get_by_text("30000 is out of range: 1000 to 20000.").wait_for()
    dialog.locator("[name=rate]").fill("9600")
    dialog.locator("[name=rate]").press("Enter")
    row = page.locator(f'tr[data-line="{lin}"]')
    row.get_by_text("9600, master").wait_for()
    row.get_by_role("button", name="Stop").click()
    row.get_by_role("button", name="Start").wait_for()


def test_changed_register_bits_are_marked(page: Page, hub: canwire.Hub) -> None:
    place = next(place for place in canwire.every_line(hub) if place.board.kind == "inducan104")
    chip = page.locator(f'[data-chip="{place.address}"]')
    chip.locator("summary").click()
    mode = canwire.WantedMode(500_000).mode(place.info.capabilities)
    with canwire.start_line(hub, place, mode) as control:
        chip.locator('tr[data-register="MOD"]').wait_for()
        counts(chip.locator('tr[data-register="MOD"] b.changed'), 0)
        control.stop()
        chip.locator('tr[data-register="MOD"] b.changed').first.wait_for()
    assert chip.get_attribute("open") is not None


@pytest.mark.finding("page 8", "page B6")
def test_two_hundred_boards_are_a_compact_list_that_is_searched(home: Path) -> None:
    boards = "".join(
        f'[[board]]\nkind = "usb-to-can-fd"\nserial = "HW{number:06}"\nbuses = ["can{number % 70}", "", ""]\n'
        for number in range(200)
    )
    buses = "".join(f'[[bus]]\nname = "can{number}"\n' for number in range(70))
    with (
        served_here(home, buses + boards, time="real") as address,
        served_site(address) as site,
        somebody(site) as client,
    ):
        shown = client.get("/boards/tree").text
        assert shown.count("<section") == 40
        assert "40 of 200 boards are shown" in shown
        assert 'class="compact"' in shown
        found = client.get("/boards/tree", params={"q": "hw000123"}).text
        assert found.count("<section") == 1
        assert client.get("/boards/tree", params={"q": "can69 usb"}).text.count("<section") == 2
        table = client.get("/statistics/table").text
        assert (table.count("<tr>"), "40 of 400 lines are shown" in table) == (41, True)
        assert client.get("/statistics/table", params={"q": "HW000123 can53"}).text.count("<tr>") == 2
        with watching(site, [f"HW{number:06}:0" for number in range(200)]) as viewer:
            assert len({line["bus"] for line in viewer.lines}) == 70
