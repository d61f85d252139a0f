"""Writes tracks as a PNG or SVG file, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire import ExtraMissing

if TYPE_CHECKING:
    from canwire.commands.plot.tracks import Track, Tracks

try:
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import FixedLocator, FuncFormatter
except ModuleNotFoundError:
    raise ExtraMissing("matplotlib", "plot") from None

_MOST = 5000  # samples of a track
_WIDTH, _PANEL, _REST = 11.0, 2.4, 1.1  # inches
_FEW_TEXTS = 16
_STYLE: Any = {"svg.fonttype": "none", "svg.hashsalt": "canwire", "axes.grid": True, "grid.alpha": 0.3}


def write_picture(path: str, tracks: Tracks, title: str) -> None:
    """Draw a panel for each unit, all with the same time axis. Raises OSError."""
    panels = tracks.panels(_MOST)
    with matplotlib.rc_context(_STYLE):
        figure = Figure(figsize=(_WIDTH, _PANEL * len(panels) + _REST), layout="constrained")
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        figure.suptitle(title, fontsize="medium")
        colour = 0
        for axis, panel in zip(axes, panels, strict=True):
            for track in panel:
                axis.step(track.times_s, track.values, where="post", linewidth=1.1, color=f"C{colour}",
                          label=track.name, **({"marker": "."} if len(track.values) == 1 else {}))  # fmt: skip
                colour += 1
            axis.set_ylabel(panel[0].label.unit)
            axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
            _name_values(axis, panel)
        axes[-1].set_xlabel("s")
        suffix = path.rpartition(".")[2].lower()
        figure.savefig(path, dpi=110, metadata={"Date": None} if suffix == "svg" else None)


def _name_values(axis: Any, panel: list[Track]) -> None:
    """Label the axis with the signal's value texts instead of numbers if few different values occur."""
    choices = dict(panel[0].label.choices)
    met = sorted({float(value) for track in panel for value in track.values})
    if choices and len(met) <= _FEW_TEXTS:
        axis.yaxis.set_major_locator(FixedLocator(met))
        axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: choices.get(value, f"{value:g}")))
