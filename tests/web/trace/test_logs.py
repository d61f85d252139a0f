"""Logs that are opened, looked at as if they were live, and saved in every format."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from websockets.exceptions import ConnectionClosedOK
from websockets.sync.client import connect

import canwire
from canwire import Frame, LogEntry, LogMark, MarkKind
from canwire.web.server import Site
from canwire.web.trace import logs
from canwire.web.trace.logs import writable_formats
from canwire.web.trace.opened import OpenedLogs
from tests.cases import each
from tests.hubs import LONG_S, until
from tests.web.conftest import at, tab
from tests.web.trace.watching import Watching, rows_with

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser

pytestmark = pytest.mark.conforms("N-53")

SECOND = 1_000_000_000
ENTRIES = [
    LogEntry(
        1_700_000_000 * SECOND + number * 1_000_000,
        f"can{number % 2}",
        Frame(
            0x100 + number, bytes([number, 0xAB]), timestamp_ns=1_700_000_000 * SECOND + number * 1_000_000
        ),
        "T" if number % 3 else "R",
    )
    for number in range(60)
]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "drive.blf"
    with canwire.create_log(path) as writer:
        writer.write_many(ENTRIES)
    return path


def opened(client: httpx.Client, path: Path) -> str:
    answer = client.post("/trace/open", params={"name": path.name}, content=path.read_bytes())
    assert answer.status_code == 200, answer.text
    return str(answer.json()["key"])


@pytest.mark.finding("page B5")
def test_its_rows_are_those_of_the_file_filtered_and_numbered(
    steady: Site, asker: httpx.Client, log: Path
) -> None:
    key = opened(asker, log)
    try:
        with connect(f"ws://127.0.0.1:{steady.port}/trace/live", max_size=None) as socket:
            viewer = Watching(socket, ["can0", "can1"], source=key)
            viewer.until(lambda one: len(one.frames) == len(ENTRIES))
            assert [frame.id for frame in viewer.frames] == [0x100 + number for number in range(60)]
            viewer.look(["can1"], source=key, filter="100-10F & tx", number=2)
            viewer.until(lambda one: one.head.get("look") == 2 and len(one.frames) == 5)
            assert [frame.id - 0x100 for frame in viewer.frames] == [1, 5, 7, 11, 13]
    finally:
        assert asker.post("/trace/close", data={"key": key}).status_code == 200


@pytest.mark.parametrize("form", writable_formats())
def test_what_is_shown_is_saved_and_opens_again(
    steady: Site, asker: httpx.Client, log: Path, tmp_path: Path, form: str
) -> None:
    key = opened(asker, log)
    query = {"source": key, "lines": "can0,can1", "filter": "110-11F", "format": form, "errors": "true"}
    while asker.get("/trace/lines", params={"source": key}).json()["logs"][-1]["reading"]:
        pass
    answer = asker.get("/trace/log", params=query)
    assert answer.status_code == 200, answer.text
    path = tmp_path / "saved"
    path.write_bytes(answer.content)
    with canwire.open_log(path, format=form) as saved:
        assert [one.frame.id for one in saved if one.frame is not None] == list(range(0x110, 0x120))
    asker.post("/trace/close", data={"key": key})


@pytest.mark.finding("page A1")
def test_what_a_log_says_is_missing_is_a_row(steady: Site, asker: httpx.Client, tmp_path: Path) -> None:
    path = tmp_path / "gap.csv"
    stamp = ENTRIES[0].timestamp_ns
    with canwire.create_log(path) as writer:
        writer.write_many([ENTRIES[0], LogEntry(stamp, "can0", LogMark(MarkKind.LOST, stamp, 7)), ENTRIES[2]])
    key = opened(asker, path)
    with connect(f"ws://127.0.0.1:{steady.port}/trace/live", max_size=None) as socket:
        viewer = Watching(socket, ["can0"], source=key)
        viewer.until(lambda one: len(one.rows) == 3)
        assert viewer.rows["record"]["info"].tolist()[1] == 0xF1
        assert viewer.rows["record"]["data"][1, 0] == 7
    asker.post("/trace/close", data={"key": key})


def test_a_file_that_is_no_log_is_told(steady: Site, asker: httpx.Client, tmp_path: Path) -> None:
    path = tmp_path / "nonsense.log"
    path.write_bytes(b"\x00\x01\x02" * 100)
    key = opened(asker, path)
    with connect(f"ws://127.0.0.1:{steady.port}/trace/live", max_size=None) as socket:
        viewer = Watching(socket, ["can0"], source=key)
        viewer.until(lambda one: one.head.get("trouble"))
        assert "is no log that canwire knows" in viewer.head["trouble"]
    asker.post("/trace/close", data={"key": key})


@each("query", [{"source": "log-77", "lines": "can0"}, {"lines": ""}, {"lines": "HW1:0", "format": "x"}])
def test_what_is_not_there_cannot_be_saved(asker: httpx.Client, query: dict[str, str]) -> None:
    assert asker.get("/trace/log", params=query).status_code == 422


def test_where_the_disk_is_full_it_is_told_and_nothing_is_left(
    asker: httpx.Client, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    key = opened(asker, log)
    monkeypatch.setattr(logs, "write_rows", full)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    answer = asker.get("/trace/log", params={"source": key, "lines": "can0"})
    assert (answer.status_code, "No space left" in answer.json()["message"]) == (409, True)
    assert list(tmp_path.glob("canwire-web-*")) == []
    asker.post("/trace/close", data={"key": key})


def test_a_part_of_a_log_or_none_leaves_nothing(
    asker: httpx.Client, log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    key = opened(asker, log)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    query = {"source": key, "lines": "can0"}
    for part, status in (("bytes=0-9", 206), ("bytes=9999999-", 416), ("bytes=x", 400)):
        assert asker.get("/trace/log", params=query, headers={"Range": part}).status_code == status
    until(lambda: not list(tmp_path.glob("canwire-web-*")))
    asker.post("/trace/close", data={"key": key})


@pytest.mark.finding("page 14")
def test_in_the_browser(browser: Browser, steady: Site, log: Path) -> None:
    """Two clicks to see a log, one to be back. Without rows the page says why."""
    with tab(browser, at(steady, "trace")) as page:
        page.locator("#log-file").set_input_files(log)
        rows_with(page, id="101").wait_for()
        page.locator("#shown", has_text="60").wait_for()
        page.locator("#filter").press_sequentially("data: 0A")
        page.locator("#shown", has_text="1").wait_for()
        rows_with(page, id="10A").wait_for()
        page.locator("#save").click()
        page.get_by_label("Format of the file").select_option("asc")
        with page.expect_download() as downloading:
            page.locator("#save-now").click()
        assert " 10A " in downloading.value.path().read_text()
        page.get_by_role("button", name="Close this log").click()
        page.get_by_text("drive.blf is closed.").wait_for()
        page.locator("#filter").fill("")
        page.get_by_text("HW000001:0 does not run: start it under Boards.").wait_for()
        told = {"address": "HW1:0", "bus": "can0", "kind": "CAN", "running": True, "state": "bus-off"}
        gone = {"running": False, "trouble": "", "files": [], "rows": 0, "number": 0}
        answer = {"lines": [told], "logs": [], "recording": gone, "replay": gone}
        page.route("**/trace/lines?*", lambda route: route.fulfill(json=answer))
        page.get_by_text(
            "HW1:0 is bus-off: it receives nothing until it is recovered under Boards."
        ).wait_for()


def test_a_log_that_is_looked_at_stays_so_until_it_is_closed(
    browser: Browser, steady: Site, asker: httpx.Client, log: Path
) -> None:
    """Also when another view is visited meanwhile; and somebody else may close it, before that or afterwards."""
    with tab(browser, at(steady, "trace")) as page:
        closing = page.get_by_role("button", name="Close this log")
        live = page.locator("body[data-listening=yes] #lines input:checked[value='HW000001:0']")
        for looks in ("here", "elsewhere"):
            page.locator("#log-file").set_input_files(log)
            closing.wait_for()
            key = page.locator("#source").input_value()
            page.goto(f"{steady.url}send")
            if looks == "here":
                page.goto(f"{steady.url}trace")
                page.locator("#shown", has_text="60").wait_for()
                closing.wait_for()
                assert page.locator("#source").input_value() == key
            asker.post("/trace/close", data={"key": key})
            if looks == "here":
                page.get_by_text("drive.blf is closed.").wait_for()
            else:
                page.goto(f"{steady.url}trace")
            live.wait_for()
            assert not closing.is_visible()


def test_who_looks_at_a_log_that_is_closed_is_let_go(steady: Site) -> None:
    with connect(f"ws://127.0.0.1:{steady.port}/trace/live", max_size=None) as socket:
        Watching(socket, ["can0"], source="log-999")
        with pytest.raises(ConnectionClosedOK):
            socket.recv(LONG_S)


def test_another_server_gives_other_keys(log: Path) -> None:
    """A tab that comes back to a server that was started again would show another log under the name of its own."""
    keys = set()
    for _ in range(2):
        opened_logs = OpenedLogs()
        folder = tempfile.TemporaryDirectory()
        keys.add(opened_logs.open(log.name, folder, Path(shutil.copy(log, folder.name))))
        opened_logs.close_all()
        assert not Path(folder.name).exists()
    assert len(keys) == 2
