"""The library's pages by topic: every public name is on one, and each example prints what stands below it."""

from __future__ import annotations

import doctest
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import api_pages
import canwire
from tests.docs.blocks import ROOT

TOPICS = api_pages.topics()
NEEDS = {
    "databases": "cantools",
    "ports": "cantools",
    "descriptions": "cantools",
    "simulation": "cantools",
    "traces": "duckdb",
}


@pytest.fixture
def names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Any]]:
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(ROOT)
    with canwire.Lab() as lab, canwire.connect(time="virtual") as hub:
        yield {
            **{name: getattr(canwire, name) for name in canwire.__all__},
            "lab": lab,
            "bus": lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000),
            "lin": lab.lin_bus("lin0"),
            "hub": hub,
            "home": tmp_path,
        }


@pytest.mark.parametrize("topic", TOPICS, ids=[topic.page for topic in TOPICS])
def test_an_example_prints_what_it_says(topic: api_pages.Topic, names: dict[str, Any]) -> None:
    if topic.page in NEEDS:
        pytest.importorskip(NEEDS[topic.page])
    example = doctest.DocTestParser().get_doctest(topic.example, names, topic.page, None, 0)
    assert example.examples
    told: list[str] = []
    assert doctest.DocTestRunner(verbose=False).run(example, out=told.append).failed == 0, "".join(told)


def test_every_name_is_in_one_topic() -> None:
    listed = Counter(name for topic in TOPICS for name in topic.names)
    assert set(listed) == set(canwire.__all__)
    assert set(listed.values()) == {1}
    assert 40 <= len(TOPICS) <= 60


def test_a_page_shows_inherited_members_and_no_others_than_canwire_s() -> None:
    (node,) = (topic for topic in TOPICS if topic.names == ["LabNode"])
    text = api_pages.text_of(node)
    assert ".. autoclass:: canwire.LabNode\n   :members:\n   :inherited-members: Generic, object\n" in text
