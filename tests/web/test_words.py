"""The words: complete in both languages, and every one that is used is there."""

from __future__ import annotations

import re
import string
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from canwire import BadFrame, CanwireError, InUse, NoChannel
from canwire.web.words import HERE, LANGUAGES, Trouble, folders, preferred, read, words_in
from tests.cases import each

if TYPE_CHECKING:
    import httpx2 as httpx

pytestmark = pytest.mark.conforms("PG-14")
TEMPLATES = sorted(HERE.rglob("*.jinja"))
SCRIPTS = [path for path in sorted(HERE.rglob("*.js")) if path.parent.name != "vendor"]
SOURCES = sorted(HERE.rglob("*.py"))


def names_in(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


@each("folder", folders(), ids=lambda folder: folder.name)
def test_both_languages_say_the_same_things(folder: Path) -> None:
    english, german = read(folder, "en"), read(folder, "de")
    assert sorted(english) == sorted(german)
    differing = [key for key in english if names_in(english[key]) != names_in(german[key])]
    assert differing == []


@each("path", [*TEMPLATES, *SCRIPTS, *SOURCES], ids=lambda path: str(path.relative_to(HERE)))
def test_every_word_that_is_used_is_there(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    used = set(re.findall(r"""\b(?:t|word)\(\s*"([a-z]+\.[a-z0-9-]+)"\s*[,)]""", text))
    texts = words_in("en").texts
    assert sorted(used - set(texts)) == []
    for start in re.findall(r"""\b(?:t|word)\(\s*f?["`]([a-z]+\.[a-z0-9-]+-)(?:" ~|\{|\$\{)""", text):
        assert any(key.startswith(start) for key in texts), start


@each(
    ("chosen", "accepted", "language"),
    [
        (None, "", "en"),
        (None, "de-DE,de;q=0.9,en;q=0.8", "de"),
        (None, "fr,en;q=0.5,de;q=0.7", "de"),
        (None, "fr", "en"),
        (None, "de;q=x,en", "en"),
        ("de", "en", "de"),
        ("xx", "de", "de"),
    ],
)
def test_the_language_is_the_chosen_one_or_the_browser_s(
    chosen: str | None, accepted: str, language: str
) -> None:
    assert preferred(chosen, accepted) == language


def test_every_language_has_its_file_in_every_folder() -> None:
    missing = [
        (folder.name, code)
        for folder in folders()
        for code in LANGUAGES
        if not (folder / "words" / f"{code}.toml").exists()
    ]
    assert missing == []


@each(
    ("error", "english", "german"),
    [
        (InUse("HW1:0: held by x"), "HW1:0: held by x", "Das hat schon jemand anderes (HW1:0: held by x)"),
        (NoChannel("none"), "none", "Das hat schon jemand anderes (none)"),
        (BadFrame("no"), "no", "Dieser Wert geht hier nicht (no)"),
        (KeyError("k"), "'k'", "'k'"),
    ],
)
def test_errors_begin_with_a_sentence_of_the_language(error: Exception, english: str, german: str) -> None:
    assert (words_in("en").error(error), words_in("de").error(error)) == (english, german)


@pytest.mark.finding("page 17")
def test_an_error_of_any_kind_has_a_german_sentence_though_it_is_shown_later() -> None:
    kept = Trouble.of(CanwireError("late"))
    assert (words_in("en").trouble(kept), words_in("de").trouble(kept)) == ("late", "Das ging nicht (late)")
    assert words_in("de").told("conflict", "two rates") == "So ginge es auf Kupfer nicht (two rates)"
    assert words_in("de").trouble("") == ""


@pytest.mark.finding("page 17")
def test_what_is_wrong_with_a_row_is_said_in_the_viewer_s_language(asker: httpx.Client) -> None:
    kept = asker.post("/send/put", data={"line": "HW000001:0", "format": "classic", "id": "1"}).json()
    (number,) = re.findall(r"\d+", kept["message"])
    try:
        asker.post("/send/now", data={"number": number})
        english, german = (asker.get("/send/list", params={"lang": one}).text for one in ("en", "de"))
    finally:
        asker.post("/send/remove", data={"number": number})
    assert '<span class="fault">HW000001:0 does not run' in english
    assert '<span class="fault">Das geht nicht in diesem Zustand (HW000001:0 does not run' in german
    started = {"line": "HW000001:0", "rate": "999983"}
    answer = asker.post("/boards/up", params={"lang": "de"}, data=started).json()["faults"]["rate"]
    assert answer.startswith("Diese Bitrate geht hier nicht (")


@pytest.mark.finding("page A8")
def test_no_word_has_backticks_nor_what_the_hub_says() -> None:
    for language in LANGUAGES:
        assert [key for key, text in words_in(language).texts.items() if "`" in text] == []
    assert words_in("en").told("conflict", "stop it: `canwire stop can0`") == "stop it: canwire stop can0"


@pytest.mark.finding("page 17")
def test_decimals_have_the_language_s_point() -> None:
    english, german = words_in("en"), words_in("de")
    assert (english.decimal(1.25, 1), german.decimal(1.25, 1)) == ("1.2", "1,2")
    assert [german.localised(text) for text in ("-1.5", "1.5 of", "7", "yes.")] == [
        "-1,5",
        "1.5 of",
        "7",
        "yes.",
    ]
