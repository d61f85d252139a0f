"""Draws docs/demo.svg, the README's picture, from what `canwire demo` prints.

canwire demo | python docs/demo_picture.py > docs/demo.svg
"""

from __future__ import annotations

import sys
from html import escape

SHOWN = ("-- ", "200   [2]", "302   [1]")  # the story: events, what the controller says, what fan 2 says
LINE, LEFT, TOP, WIDTH = 19, 16, 30, 900
COLOURS = (("BUS_OFF", "#ff6b6b"), ("ERROR_", "#ffb454"), ("-- ", "#7fd962"))


def colour(line: str) -> str:
    return next((shade for word, shade in COLOURS if word in line), "#c9d1d9")


def picture(text: str) -> str:
    """One line of monospaced SVG text for each line of the story, and the summary behind it."""
    lines = [line.rstrip() for line in text.splitlines()]
    body = [line for line in lines if line.startswith(" (") and any(word in line for word in SHOWN)]
    summary = [line for line in lines if line and not line.startswith(" (")]
    story = ["$ canwire demo", *thinned(body), "", *summary]
    rows = "".join(
        f'<text x="{LEFT}" y="{TOP + k * LINE}" fill="{colour(line)}" xml:space="preserve">{escape(line)}</text>\n'
        for k, line in enumerate(story)
    )
    height = TOP + len(story) * LINE
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" font-family="monospace" '
        f'font-size="14"><rect width="100%" height="100%" rx="8" fill="#0d1117"/>\n{rows}</svg>\n'
    )


def thinned(body: list[str], most: int = 26) -> list[str]:
    """The part around the failure: from shortly before it to shortly after the fan is back."""
    first = next((k for k, line in enumerate(body) if "-- " in line), 0)
    return body[max(0, first - 3) :][:most]


if __name__ == "__main__":
    sys.stdout.write(picture(sys.stdin.read()))
