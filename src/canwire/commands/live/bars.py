"""A reading of a bus as a line: in words, or with a bar for terminals."""

from __future__ import annotations

from canwire.commands.live.meter import Reading

_BUSY, _FULL = 50.0, 80.0  # percent: yellow, red
_LEAST = 10  # columns of a bar
_RESET = "\x1b[0m"


def format_reading(reading: Reading, width: int) -> str:
    """`can0      40.0 %  peak  62.1 %  mean  38.7 %  1748.0 frames/s  0.0 errors/s  500000 bit/s`"""
    return f"{reading.bus:{width}} {_figures(reading)}"


def format_bar(reading: Reading, width: int, columns: int, *, coloured: bool) -> str:
    """The same after a bar that fills a terminal of this width, with a mark at the peak; cut on a narrow terminal."""
    figures = _figures(reading)
    room = columns - width - len(figures) - 5
    if room < _LEAST:
        return f"{reading.bus:{width}} {figures}"[: columns - 1]
    full, mark = round(reading.load * room / 100), min(room - 1, round(reading.peak * room / 100))
    cells = ["#" if at < full else "-" for at in range(room)]
    if reading.peak > 0 and mark >= full:
        cells[mark] = "|"
    bar = "".join(cells)
    if coloured:
        bar = f"\x1b[{_colour(reading.load)}m{bar}{_RESET}"
    return f"{reading.bus:{width}} [{bar}] {figures}"


def format_total(reading: Reading) -> str:
    """`can0: mean 38.7 %, peak 62.1 %, 5250 frames, 0 errors`"""
    return (
        f"{reading.bus}: mean {reading.mean:.1f} %, peak {reading.peak:.1f} %, {reading.frames} frames, "
        f"{reading.errors} errors"
    )


def _figures(reading: Reading) -> str:
    return (
        f"{reading.load:5.1f} %  peak {reading.peak:5.1f} %  mean {reading.mean:5.1f} %  "
        f"{reading.frames_s:7.1f} frames/s  {reading.errors_s:5.1f} errors/s  {reading.rates}"
    )


def _colour(load: float) -> str:
    return "31" if load >= _FULL else "33" if load >= _BUSY else "32"
