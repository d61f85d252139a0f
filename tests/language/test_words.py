"""No text uses words that readers stumbled over (issue 38)."""

from __future__ import annotations

from tests.language.words import every_text, instead, uses


def test_texts_use_none_of_the_words() -> None:
    found = [f"{use}: write {instead(use.words)}" for use in uses(every_text())]
    assert not found, "\n".join(found)


def test_a_word_in_a_text_is_found_with_its_line(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("tests.language.words.ROOT", tmp_path)
    monkeypatch.setattr("tests.language.texts.ROOT", tmp_path)
    page = tmp_path / "page.md"
    page.write_text("A bus.\nIt goes\non, and others go on.\n", "utf-8")
    assert [str(use) for use in uses([page])] == ["page.md:2: goes on", "page.md:3: go on"]
