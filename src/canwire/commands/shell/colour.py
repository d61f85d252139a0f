"""Colours on a terminal: none in files and pipes, none where NO_COLOR is set (https://no-color.org)."""

from __future__ import annotations

import os
import sys
from typing import TextIO

RED, GREEN, YELLOW = "31", "32", "33"


def has_colours(stream: TextIO | None = None) -> bool:
    """Whether the stream (default: standard output) is a terminal, without NO_COLOR and TERM=dumb."""
    stream = sys.stdout if stream is None else stream
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def painted(text: str, colour: str, stream: TextIO | None = None) -> str:
    """Return the text in this colour; unchanged for the colour "", or if the stream shows no colours."""
    if not colour or not has_colours(stream):
        return text
    return f"\x1b[{colour}m{text}\x1b[0m"
