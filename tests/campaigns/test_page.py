"""A campaign as a page: what fails is named, counted and drawn, and nothing that a run said gets into the page."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from canwire import BadValue
from canwire.campaigns.junit import Played, check_report
from canwire.campaigns.page import write_page
from canwire.campaigns.playing import CampaignRun
from canwire.campaigns.shares import parameters_of

pytestmark = pytest.mark.conforms("N-60")


def runs(count: int = 48) -> list[CampaignRun]:
    """Those with rate 2 fail, whatever the noise is."""
    return [
        CampaignRun(
            number,
            1,
            {"noise": number * 0.25, "rate": number % 3},
            "failed" if number % 3 == 2 else "passed",
            "5 < 6 <script>\udc80" if number % 3 == 2 else "",
            trace="Traceback\n" if number % 3 == 2 else "",
            wall_s=number / 100,
        )
        for number in range(count)
    ]


def test_the_parameter_that_fails_comes_first() -> None:
    rate, noise = parameters_of(runs())
    assert (rate.name, rate.spread) == ("rate", 1.0)
    assert [tuple(share) for share in rate.shares] == [("0", 16, 0), ("1", 16, 0), ("2", 16, 16)]
    assert noise.spread < 0.5
    assert sum(share.runs for share in noise.shares) == 48
    assert [share.label for share in noise.shares][:2] == ["from 0", "from 1.5"]


def test_many_words_are_few_classes() -> None:
    found = [CampaignRun(number, 1, {"name": f"{number:02}"}, "passed") for number in range(30)]
    (name,) = parameters_of(found)
    assert [share.label for share in name.shares][-2:] == ["10", "19 others"]
    assert name.shares[-1].runs == 19


def test_the_page(tmp_path: Path) -> None:
    path = tmp_path / "out.html"
    write_page(path, Played("bench.py", "flips", 7), reversed(runs()))
    text = path.read_text()
    assert "48 runs of <code>bench.py</code> with seed 7: 32 passed, 16 failed." in text
    assert (
        "<h3>failed: 5 &lt; 6 &lt;script&gt;\\udc80</h3><p>16 runs; the first is run 2, noise=0.5, rate=2.</p>"
        in text
    )
    assert "canwire campaign bench.py --seed 7 --repeat 2" in text
    assert text.index("<h2>By rate</h2>") < text.index("<h2>By noise</h2>") < text.index("<h2>Durations</h2>")
    assert "rate 2, noise from 0: 2 of 2 failed" in text
    for drawing in text.split("<svg")[1:]:  # each is well formed
        ElementTree.fromstring("<svg" + drawing.partition("</svg>")[0] + "</svg>")
    assert list(tmp_path.iterdir()) == [path]


def test_a_campaign_that_passes_has_no_failures(tmp_path: Path) -> None:
    path = tmp_path / "out.html"
    write_page(path, Played("a.py", "a", 1), [CampaignRun(0, 1, {}, "passed")])
    assert "Failures" not in path.read_text()


def test_other_endings_are_refused(tmp_path: Path) -> None:
    assert check_report(tmp_path / "a.html") == tmp_path / "a.html"
    with pytest.raises(BadValue, match=r"\.xml, or a page"):
        check_report(tmp_path / "a.pdf")
