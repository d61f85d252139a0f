"""docs/check_site.py, which CI runs on the built site, finds what it is there to find."""

from __future__ import annotations

from pathlib import Path

import pytest

import check_site
from tests.missing import find_browser

GOOD = '<h1 id="top">Title</h1><nav class="sidebar-tree"><a href="other.html#there">Other</a></nav>'


@pytest.fixture
def site(tmp_path: Path) -> Path:
    (tmp_path / "other.html").write_text('<h1 id="there">Other</h1>')
    (tmp_path / "index.html").write_text(GOOD)
    return tmp_path


def test_links_that_lead_somewhere(site: Path) -> None:
    (site / "more.html").write_text(
        '<a href="index.html">1</a><a href="#">2</a><a href="https://example.org/x">3</a>'
    )
    assert list(check_site.dead_links(site)) == []


def test_dead_links_are_found(site: Path) -> None:
    (site / "bad.html").write_text(
        '<a href="gone.html">1</a><a href="other.html#nowhere">2</a><img src="a.svg"><a href="#here">4</a>'
    )
    assert list(check_site.dead_links(site)) == [
        "bad.html: gone.html", "bad.html: other.html#nowhere", "bad.html: a.svg", "bad.html: #here",
    ]  # fmt: skip


def test_what_does_not_fit_is_found(site: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chromium = find_browser()
    (site / "wide.html").write_text('<h1>Wide</h1><div style="width:600px">.</div>')
    monkeypatch.setattr(check_site, "PAGES", ("index", "wide"))
    assert sorted(check_site.misfits(site, chromium)) == [
        "wide: 608 pixels wide in a window of 390",
        "wide: no navigation in a window of 1280 pixels",
        "wide: no navigation in a window of 390 pixels",
    ]
