"""The texts of the page in English and German: each view's words/en.toml and words/de.toml."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent
LANGUAGES = {"en": "English", "de": "Deutsch"}
USUAL = "en"


class Trouble(str):
    """An error's message that is kept and shown later: it remembers what kind of error it was, for `Words.trouble`."""

    kinds: tuple[str, ...] = ()

    @classmethod
    def of(cls, error: Exception) -> Trouble:
        made = cls(error)
        made.kinds = tuple(kind.__name__.lower() for kind in type(error).__mro__)
        return made

    @classmethod
    def said(cls, text: str, kind: str) -> Trouble:
        """Make a text of this kind, for which the word base.error-KIND exists."""
        made = cls(text)
        made.kinds = (kind,)
        return made


class Words:
    """The words of one language. Keys are "view.key"; `word(key, name=...)` replaces `{name}` in a text."""

    def __init__(self, language: str, texts: Mapping[str, str]) -> None:
        self.language = language
        self.texts = texts

    def __call__(self, key: str, **values: object) -> str:
        return self.texts[key].format(**values)

    def decimal(self, number: float, digits: int) -> str:
        """A number with the language's decimal point or comma."""
        return f"{number:.{digits}f}".replace(".", self.texts["base.decimal-point"])

    def localised(self, text: str) -> str:
        """Replace the decimal point of a number by that of the language; any other text stays unchanged."""
        return re.sub(r"(?<=^)(-?\d+)\.(?=\d+$)", rf"\1{self.texts['base.decimal-point']}", text)

    def error(self, error: Exception) -> str:
        """Return an error's English message, after a sentence in this language if one exists for it."""
        return self.trouble(Trouble.of(error))

    def trouble(self, text: str) -> str:
        """Return the text of a kept error message in the same form as `error`; other texts stay unchanged.

        Backticks are removed: they are for terminals."""
        keys = (f"base.error-{kind}" for kind in getattr(text, "kinds", ()))
        sentence = next((self.texts[key] for key in keys if key in self.texts), "")
        plain = text.replace("`", "")
        return f"{sentence} ({plain})" if sentence else plain

    def told(self, kind: str, text: str) -> str:
        """Return an English sentence of the hub, with base.error-KIND before it."""
        return self.trouble(Trouble.said(text, kind))


def read(folder: Path, language: str) -> dict[str, str]:
    """The words of one view's folder."""
    path = folder / "words" / f"{language}.toml"
    found = tomllib.loads(path.read_text(encoding="utf-8"))
    return {f"{folder.name}.{key}": str(text) for key, text in found.items()}


def folders() -> list[Path]:
    """Every folder that has words."""
    return sorted(path.parent for path in HERE.glob("*/words"))


@cache
def words_in(language: str) -> Words:
    """Return the words of all views."""
    texts: dict[str, str] = {}
    for folder in folders():
        texts |= read(folder, language)
    return Words(language, texts)


def preferred(chosen: str | None, accepted: str) -> str:
    """Return the chosen language, else the first supported one of an Accept-Language header."""
    if chosen in LANGUAGES:
        return str(chosen)
    return next((tag for tag in _by_quality(accepted) if tag in LANGUAGES), USUAL)


def _by_quality(accepted: str) -> Iterable[str]:
    ranked = []
    for place, part in enumerate(accepted.split(",")):
        tag, _, quality = part.partition(";q=")
        try:
            weight = float(quality or 1)
        except ValueError:
            weight = 0.0
        ranked.append((-weight, place, tag.strip().lower().partition("-")[0]))
    return [tag for _, _, tag in sorted(ranked)]
