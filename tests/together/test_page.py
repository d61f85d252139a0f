"""docs/sharing.md says what table.py holds."""

from __future__ import annotations

import pytest

from tests.together.page import PAGE, written


@pytest.mark.conforms("N-03", "N-05")
def test_the_page_has_the_matrix() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert text.count("<!-- end of") == 5
    assert written(text) == text, "run: python -m tests.together.page"
