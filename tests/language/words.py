"""Words that no text of canwire uses, since readers stumbled over them.

`python -m tests.language.words [PATH ...]` lists them. They come from two readings by strangers;
what to write instead is beside each. Comments count, too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from tests.language.texts import ROOT, Text, pages, sources

INSTEAD = {
    r"whoever": "the program that, anyone who",
    r"anybody": "anyone, any program",
    r"so often": "N times",
    r"; again:": "may be given several times",
    r"anew": "again, from the start, a new ...",
    r"go(?:es|ing)? on|went on": "continues",
    r"at once": "immediately; at the same time",
    r"(?:is|are|was|were|be|been|being) told": "receives, is notified, is reported",
    r"of (?:its|their|his|her) own": "its own ..., a separate ...",
    r"as far as": "where, up to, if",
    r"stands": "is, means (stands for)",
    r"for ever": "forever, without end",
    r"mend(?:s|ed|ing)?": "fix, repair",
}
PATTERN = re.compile(
    rf"(?<![\w-])(?:{'|'.join(INSTEAD)})(?![\w])".replace(" ", r"(?:\s|#(?!:)|\*|//)+"), re.I
)
ALLOWED = frozenset(  # (path from the root, the words): quotations and names of others
    {
        ("src/canwire/hub/links/network/access.py", "anybody"),  # the setting's value since 0.1
        ("src/canwire/hub/links/network/keys.py", "anybody"),
    }
)


def uses(paths: Iterable[Path]) -> Iterator[Text]:
    """Each use of such words in these files, with the line that it begins on."""
    for path in paths:
        text = path.read_text("utf-8")
        for match in PATTERN.finditer(text):
            words = " ".join(re.sub(r"[#*/]", " ", match[0]).split())  # a comment's words may be on two lines
            if (str(path.relative_to(ROOT)), words.lower()) not in ALLOWED:
                yield Text(path, text.count("\n", 0, match.start()) + 1, words)


def instead(words: str) -> str:
    """What to write in place of these words."""
    return next(better for pattern, better in INSTEAD.items() if re.fullmatch(pattern, words, re.IGNORECASE))


def every_text() -> list[Path]:
    """All pages and sources."""
    return [*pages(), *sources()]


def main() -> None:
    """Prints each use under the paths that are named, or in all texts."""
    named = [Path(word).resolve() for word in sys.argv[1:]]
    for use in uses(
        path for path in every_text() if not named or any(path.is_relative_to(name) for name in named)
    ):
        print(use)


if __name__ == "__main__":
    main()
