"""Pages that are written by scripts say what the scripts say now."""

from __future__ import annotations

import pytest


@pytest.mark.parametrize("name", ["configuration", "verbs"])
def test_a_page_is_up_to_date(name: str) -> None:
    module = __import__(name)
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), f"run python docs/{name}.py"
