"""Scripts and styles are asked for once."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.web.conftest import at, caller

httpx = pytest.importorskip("httpx2")
pytest.importorskip("starlette")

from canwire.web import files  # noqa: E402

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from canwire.web.server import Site

FETCHED = """performance.getEntriesByType("resource")
    .filter((one) => one.name.includes("/static/") && one.transferSize > 0).map((one) => one.name)"""
NAMED = """performance.getEntriesByType("resource").filter((one) => one.name.includes("/static/")).length"""


def test_a_page_names_files_that_may_be_kept_for_good(asker: httpx.Client) -> None:
    named = re.findall(r'(?:src|href)="(/static/[^"]+)"', asker.get("/trace").text)
    assert len(named) > 5
    for address in named:
        assert address.startswith(files.static_path() + "/")
        answer = asker.get(address)
        assert (answer.status_code, answer.headers["cache-control"]) == (200, "max-age=31536000, immutable")


def test_nothing_else_is_kept(steady: Site, asker: httpx.Client) -> None:
    for address in ("/trace", f"{files.static_path()}/base/none.js", "/static/base/base.js"):
        assert asker.get(address).headers["cache-control"] == "no-cache"
    with caller(steady) as stranger:
        refused = stranger.get(f"{files.static_path()}/base/base.js", headers={"host": "other.example"})
    assert (refused.status_code, refused.headers["cache-control"]) == (421, "no-cache")


def test_another_file_is_another_address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "base" / "static" / "vendor"
    folder.mkdir(parents=True)
    monkeypatch.setattr(files, "HERE", tmp_path)
    addresses = []
    for name, text in (("one.js", "let a"), ("one.js", "let b"), ("two.js", ""), ("three.js", "")):
        (folder / name).write_text(text)
        addresses.append(files.static_path.__wrapped__())
    assert len(set(addresses)) == len(addresses)
    assert files.static_path.__wrapped__() == addresses[-1]


def test_a_browser_asks_for_none_again(site: Site, page: Page) -> None:
    """Each change to another view asked for thirty files again, half of what it cost."""
    page.goto(at(site, "trace"))
    page.goto(at(site, "boards"))
    page.goto(at(site, "trace"))
    page.locator("main:not([inert])").wait_for()
    assert page.evaluate(NAMED) > 20
    assert page.evaluate(FETCHED) == []
