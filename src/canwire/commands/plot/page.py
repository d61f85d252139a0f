"""Writes tracks as one self-contained HTML page: the samples, and a script that draws them as SVG."""

from __future__ import annotations

import json
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from canwire.commands.plot.tracks import Tracks

_MOST = 20_000  # samples of a track: what can be zoomed into
_PAGE = Path(__file__).with_name("page.html")


def write_page(path: str, tracks: Tracks, title: str) -> None:
    """Write the tracks as an HTML page. Raises OSError."""
    panels = [
        {
            "unit": panel[0].label.unit,
            "choices": {f"{value:.9g}": text for value, text in panel[0].label.choices},
            "tracks": [
                {"name": track.name, "t": _short(track.times_s), "v": _short(track.values)} for track in panel
            ],
        }
        for panel in tracks.panels(_MOST)
    ]
    data = json.dumps(panels, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    page = _PAGE.read_text(encoding="utf-8").replace("{title}", escape(title))
    Path(path).write_text(page.replace("{data}", data), encoding="utf-8", newline="\n")


def _short(values: Any) -> list[float]:
    """Return the values rounded to nine digits, which is more than a screen shows."""
    return [float(f"{value:.9g}") for value in values.tolist()]
