"""`canwire web` on Windows, shown in Linux' chromium."""

from __future__ import annotations

from tests.web.conftest import opened_browser, tab
from tests.windows.conftest import Windows


def test_a_frame_is_seen_in_the_trace(windows: Windows, hub: str, page: str) -> None:
    windows.done("up", "HW000002:0", "--hub", hub)
    with opened_browser() as browser, tab(browser, page) as shown:
        shown.goto(page.partition("/?")[0] + "/trace")
        shown.locator("body[data-listening=yes]").wait_for()
        windows.done("send", "HW000001:0", "123#1122", "--hub", hub)
        shown.locator("#body .trace-row", has_text="11 22").first.wait_for()
