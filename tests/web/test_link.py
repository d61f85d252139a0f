"""A hub that is lost: shown, healed when it is back, and the gap counted, in the head and in the trace."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from websockets.sync.client import connect

import canwire
from canwire import HubLost
from canwire.web.trace.store.rows import GAP
from tests.hubs import LONG_S, serving
from tests.web.conftest import EMPTY, at, served_site, somebody, tab
from tests.web.trace.watching import Watching, sender, watching

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-01")


def test_the_page_heals_when_the_hub_is_back(browser: Browser, tmp_path: Path) -> None:
    with (
        serving(tmp_path, time="real") as first,
        served_site(first.address) as site,
        tab(browser, site.address) as page,
    ):
        page.get_by_text("Hub connected").wait_for()
        page.locator('tr[data-line="HW000001:0"]').wait_for()
        first.process.terminate()
        first.process.wait(LONG_S)
        page.locator("#link").get_by_text("Hub lost").wait_for()
        page.locator("#tree").get_by_text("the hub is away").wait_for()
        with serving(tmp_path, time="real"):
            page.locator("#link").get_by_text("was away 1×").wait_for()
            page.locator('tr[data-line="HW000001:0"]').wait_for()


def test_calls_fail_in_clear_words_while_it_is_away(tmp_path: Path) -> None:
    with (
        serving(tmp_path, time="real") as first,
        served_site(first.address) as site,
        somebody(site) as client,
    ):
        first.process.terminate()
        first.process.wait(LONG_S)
        for path in ("/boards/tree", "/boards", "/send", "/statistics", "/trace", "/link"):
            assert client.get(path).status_code == 200, path
        for path in ("/trace/lines", "/statistics/table", "/statistics/faults"):
            assert client.get(path).status_code == 503, path
        answer = client.post("/boards/unplug", data={"board": "HW000001"})
        assert answer.status_code == 503
        assert "the hub is away" in answer.json()["message"]


def test_the_trace_goes_on_with_a_mark_where_the_hub_was_away(tmp_path: Path) -> None:
    with (
        serving(tmp_path, time="real") as first,
        served_site(first.address) as site,
        connect(f"ws://127.0.0.1:{site.port}/trace/live") as socket,
    ):
        viewer = Watching(socket, ["HW000001:0"])
        viewer.until(lambda one: one.listening)
        first.process.terminate()
        first.process.wait(LONG_S)
        viewer.until(lambda one: "the hub is away" in one.lines[0]["trouble"])
        with serving(tmp_path, time="real") as second, canwire.connect(second.address) as hub:
            viewer.until(lambda one: (one.rows["record"]["info"] == GAP).any())
            viewer.until(lambda one: not one.lines[0]["trouble"])
            assert hub.board("HW000001").lines
            assert [gap.over for gap in site.link.gaps] == [True]


def test_who_asks_without_a_hub_is_told(tmp_path: Path) -> None:
    with serving(tmp_path, time="real") as first, served_site(first.address) as site:
        first.process.terminate()
        first.process.wait(LONG_S)
        with pytest.raises(HubLost, match="the hub is away"):
            site.link.hub  # noqa: B018


@pytest.mark.finding("page 2")
@pytest.mark.conforms("N-53")
def test_a_server_that_is_dead_or_hangs_is_said(browser: Browser, site: Site) -> None:
    """Its answers are kept back by the browser, as those of a process that is stopped are."""
    with tab(browser, site.address) as page:
        page.get_by_text("Hub connected").wait_for()
        page.route("**/link", lambda route: None)
        page.locator("#link", has_text="The server does not answer.").wait_for()
        page.locator("body.unreachable").wait_for()
        page.unroute_all(behavior="ignoreErrors")
        page.get_by_text("Hub connected").wait_for()


@pytest.mark.finding("page 14")
def test_a_page_that_was_made_without_a_hub_has_its_lines_when_it_is_back(
    browser: Browser, tmp_path: Path
) -> None:
    with (
        serving(tmp_path, time="real") as first,
        served_site(first.address) as site,
        tab(browser, EMPTY) as page,
    ):
        first.process.terminate()
        first.process.wait(LONG_S)
        page.goto(at(site, "send"))
        page.locator("#link").get_by_text("Hub lost").wait_for()
        with serving(tmp_path, time="real"):
            page.locator('#row-form option[value="HW000001:0"]').wait_for(state="attached")


@pytest.mark.finding("page 11")
@pytest.mark.conforms("N-53")
def test_after_another_hub_began_old_rows_keep_their_time_in_a_log(tmp_path: Path) -> None:
    with (
        serving(tmp_path, time="real") as first,
        served_site(first.address) as site,
        somebody(site) as client,
    ):
        with watching(site, ["HW000001:0"]) as viewer:
            with canwire.connect(first.address) as hub, sender(hub) as channel:
                channel.send(canwire.Frame(1), timeout=LONG_S)
                viewer.until(lambda one: len(one.frames) == 1)
            first.process.terminate()
            first.process.wait(LONG_S)
            viewer.until(
                lambda one: not one.listening
            )  # else the second viewer could see the first hub's line
        with (
            serving(tmp_path, time="real") as second,
            canwire.connect(second.address) as hub,
            watching(site, ["HW000001:0"]) as viewer,
            sender(hub) as channel,
        ):
            channel.send(canwire.Frame(2), timeout=LONG_S)
            viewer.until(lambda one: len(one.frames) == 2)
            log = client.get("/trace/log", params={"lines": "HW000001:0"}).text
            recent = time.time_ns()
    lines = [canwire.parse_log_line(line) for line in log.splitlines()]
    frames = [line for line in lines if isinstance(line.content, canwire.Frame)]
    assert [line.content.id for line in frames if isinstance(line.content, canwire.Frame)] == [1, 2]
    assert frames[0].timestamp_ns < frames[1].timestamp_ns <= recent
    gaps = [line for line in lines if isinstance(line.content, canwire.BusEvent)]
    assert gaps, "where the hub was away the log has an error frame, receive overflow"
