"""Panels: values of signals, switches and sliders that send them, kept by the browser and in files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import connect

import canwire
from canwire import Frame
from tests.hubs import LONG_S
from tests.web.conftest import at, counts, served_site, somebody, tab
from tests.web.test_send import receiving
from tests.web.trace.watching import sender

pytest.importorskip("cantools")
if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-10")

DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
 SG_ Running : 16|1@1+ (1,0) [0|1] "" ECU
VAL_ 256 Running 1 "yes" 0 "no" ;
"""


@pytest.fixture
def described(hub_address: str, tmp_path: Path) -> Iterator[Site]:
    path = tmp_path / "car.dbc"
    path.write_text(DBC)
    with served_site(hub_address, [str(path)]) as site:
        yield site


def test_values_are_the_newest_ones_on_their_lines(described: Site, hub: canwire.Hub) -> None:
    line = canwire.find_lines(hub, "can0")[0].address
    wanted = [[line, "Engine", "Speed"], [line, "Engine", "Running"], [line, "None", "Speed"]]
    with sender(hub) as channel, connect(f"ws://127.0.0.1:{described.port}/panels/live") as socket:
        socket.send(json.dumps({"bound": wanted}))
        while not (told := json.loads(socket.recv(LONG_S))) or told[0] is None:
            channel.send(Frame(0x100, bytes.fromhex("A00F010000000000")), timeout=LONG_S)
    assert told == [
        {"text": "1000", "unit": "rpm", "number": 1000.0},
        {"text": "yes", "unit": "", "number": 1.0},
        None,
    ]


@pytest.mark.parametrize("told", [{"bound": [["a"]]}, {"bound": [["a", "b", 3]]}, {"other": []}])
def test_a_viewer_that_talks_nonsense_is_let_go(described: Site, told: object) -> None:
    with connect(f"ws://127.0.0.1:{described.port}/panels/live") as socket:
        socket.send(json.dumps(told))
        with pytest.raises(ConnectionClosedError):
            list(socket)


def test_a_signal_that_is_set_is_sent_by_the_row_of_its_message(described: Site, hub: canwire.Hub) -> None:
    with receiving(hub) as channel, somebody(described) as client:
        line = canwire.find_lines(hub, "can0")[0].address
        wish = {"line": line, "message": "Engine", "signal": "Speed", "value": "1000"}
        assert client.post("/panels/set", data=wish).status_code == 200
        assert channel.receive(LONG_S) == Frame(0x100, bytes.fromhex("A00F000000000000"))
        assert client.post("/panels/set", data={**wish, "signal": "Running", "value": "1"}).status_code == 200
        assert channel.receive(LONG_S) == Frame(0x100, bytes.fromhex("A00F010000000000"))
        assert client.get("/send/list").text.count("data-row=") == 1
        answer = client.post("/panels/set", data={**wish, "value": "99999"})
        assert answer.status_code == 422
        assert "Possible" in str(answer.json()["faults"])


@pytest.mark.finding("page B5")
def test_in_the_browser_parts_are_added_used_kept_and_saved(
    browser: Browser, described: Site, hub: canwire.Hub
) -> None:
    with receiving(hub) as channel, tab(browser, at(described, "panels")) as page:
        for kind, signal in (("value", "Speed"), ("slider", "Speed"), ("switch", "Running")):
            page.get_by_role("button", name="Add…").click()
            page.get_by_label("Kind").select_option(kind)
            page.locator("#part-form [name=signal]").select_option(signal)
            page.get_by_role("button", name="Add it").click()
        counts(page.locator(".part"), 3)
        page.get_by_role("switch", name="Running").click()
        assert channel.receive(LONG_S) == Frame(0x100, bytes.fromhex("0000010000000000"))
        page.locator(".part", has_text="yes").wait_for()
        page.get_by_role("slider", name="Speed").fill("8000")
        assert channel.receive(LONG_S) == Frame(0x100, bytes.fromhex("007D010000000000"))
        page.locator(".part .now", has_text="8000 rpm").first.wait_for()
        with page.expect_download() as downloading:
            page.get_by_role("button", name="Save panel").click()
        saved = downloading.value.path().read_bytes()
        page.reload()
        counts(page.locator(".part"), 3)
        page.get_by_role("button", name="Remove Running").click()
        counts(page.locator(".part"), 2)
        page.locator("#panel-file").set_input_files(
            files=[{"name": "panel.json", "mimeType": "application/json", "buffer": saved}]
        )
        counts(page.locator(".part"), 3)
        page.locator("#panel-file").set_input_files(
            files=[{"name": "x.json", "mimeType": "application/json", "buffer": b'{"parts": 3}'}]
        )
        page.get_by_text("x.json is not a canwire panel.").wait_for()
