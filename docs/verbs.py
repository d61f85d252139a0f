"""Writes docs/verbs.md: every verb of `canwire` as its --help says it.

python docs/verbs.py
"""

from __future__ import annotations

import contextlib
import io
import os
from pathlib import Path
from unittest import mock

from canwire.commands import VERBS, main

PAGE = Path(__file__).resolve().parent / "verbs.md"
HEAD = """# Verbs

Written by `python docs/verbs.py` from what `canwire help VERB` prints: change that, not this page.

Exit status: 0, what a verb's help says, 2 for a mistake (one line on stderr), 130 after Ctrl-C, 141 when the program
that read the output has ended.

| verb | |
|---|---|
"""
WIDTH = "100"


def help_of(verb: str) -> str:
    shown = io.StringIO()
    with mock.patch.dict(os.environ, COLUMNS=WIDTH, NO_COLOR="1"), contextlib.redirect_stdout(shown):
        try:
            main([verb, "--help"])
        except SystemExit as ended:
            if ended.code:
                raise
    return shown.getvalue().rstrip()


def page() -> str:
    rows = "".join(f"| [{name}](#{name}) | {verb.help} |\n" for name, verb in sorted(VERBS.items()))
    parts = [f"\n## {name}\n\n```text\n{help_of(name)}\n```\n" for name in sorted(VERBS)]
    return HEAD + rows + "".join(parts)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
