"""A recording at the server: every row, for as long as wanted, whoever watches meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import Frame
from canwire.web.server import Site
from canwire.web.trace.store.rows import LOST, mark_row
from tests.cases import each
from tests.hubs import LONG_S
from tests.web.trace.watching import sender, tab_on_trace, watching

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser

pytestmark = pytest.mark.conforms("PG-04")


@pytest.mark.finding("page 12")
def test_every_frame_between_start_and_stop_is_in_the_file(
    site: Site, client: httpx.Client, hub: canwire.Hub
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    frames = [Frame(number & 0x7FF, number.to_bytes(4, "little")) for number in range(3000)]
    with watching(site, [address]) as viewer, sender(hub) as channel:
        assert client.post("/trace/record", data={"lines": address}).status_code == 200
        assert client.post("/trace/record", data={"lines": address}).status_code == 409
        for frame in frames:
            channel.send(frame, timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == len(frames))
        answer = client.post("/trace/record-stop")
        assert answer.json()["message"] == "Recorded 3000 rows, 0 missed."
        client.post("/trace/record", data={"lines": address})
        site.desk.kept["trace"].history.append(mark_row(LOST, 0, 7, 0))
        assert client.post("/trace/record-stop").json()["message"] == "Recorded 1 rows, 0 missed."
    lines = client.get("/trace/recording", params={"number": "1"}).text.splitlines()
    assert [canwire.parse_log_line(line).content for line in lines] == frames
    (missing,) = client.get("/trace/recording").text.splitlines()
    assert isinstance(canwire.parse_log_line(missing).content, canwire.BusEvent)


def test_without_a_recording_there_is_no_file(asker: httpx.Client) -> None:
    assert asker.get("/trace/recording").status_code == 404
    assert asker.post("/trace/record-stop").status_code == 200


@each("lines", ["", "nonsense", "HW1:0,../x"])
def test_a_recording_of_no_line_is_refused(asker: httpx.Client, lines: str) -> None:
    assert asker.post("/trace/record", data={"lines": lines}).status_code == 422


def test_in_the_browser(browser: Browser, site: Site, hub: canwire.Hub) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with sender(hub) as channel, tab_on_trace(browser, site, address) as page:
        page.get_by_role("button", name="Record").click()
        page.get_by_role("button", name="Stop recording").wait_for()
        channel.send(Frame(0x123), timeout=LONG_S)
        page.locator("#shown", has_text="1").wait_for()
        page.get_by_role("button", name="Stop recording").click()
        page.get_by_text("Recorded 1 rows, 0 missed.").wait_for()
        with page.expect_download() as downloading:
            page.get_by_role("link", name="Recorded file").click()
        assert "can0 123# T" in downloading.value.path().read_text()
