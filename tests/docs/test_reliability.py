"""docs/reliability.md and docs/security.md name tests, options and files that there are."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

from canwire import LogLimits
from canwire.boards.config.limits import LimitsConfig
from canwire.boards.config.tables import options

ROOT = Path(__file__).resolve().parents[2]
PAGES = ["reliability.md", "security.md"]
SHORT = {"processes": "tests/attacks/test_processes.py"}


@pytest.mark.parametrize("page", PAGES)
def test_the_tests_it_names_are_there(page: str) -> None:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for file, name in re.findall(r"`([\w/.]+)::(\w+)`", text):
        assert f"def {name}(" in (ROOT / SHORT.get(file, file)).read_text(encoding="utf-8")
    for file in re.findall(r"`((?:hub|boards)/[\w/]+\.py|ring\.py)`", text):
        assert (ROOT / "src" / "canwire" / file).exists()


def test_every_limit_is_there() -> None:
    text = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if re.match(r"\| `\w+` \| `\d+` \|", line)]
    limits = options({"limits": LimitsConfig})
    assert rows == [f"| `{limit.name}` | `{limit.default}` | {limit.help} |" for limit in limits]


def test_every_limit_of_logs_is_there() -> None:
    text = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
    for limit in fields(LogLimits):
        assert f"| `{limit.name}` | {limit.default} |" in text
