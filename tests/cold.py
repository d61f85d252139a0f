"""Programs that tests start: pytest's words, and what cold ones of python-can find on PYTHONPATH."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
WITHOUT = 'raise ImportError("left out: for it python-can would load pandas at each start, 0.4 s of the processor")\n'


def without_asammdf(folder: Path) -> str:
    """What to put on PYTHONPATH: python-can has no MF4 logs then, and starts in half of the time."""
    place = folder / "without_asammdf"
    place.mkdir(parents=True, exist_ok=True)
    (place / "asammdf.py").write_text(WITHOUT)
    return str(place)


def entry_points(folder: Path) -> str:
    """The same, and python-can finds our entry points, as where canwire is installed."""
    place = Path(without_asammdf(folder))
    info = place / "canwire_entry_points-0.dist-info"
    info.mkdir(exist_ok=True)
    entries = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]["can.interface"]
    lines = [f"{name} = {value}" for name, value in entries.items()]
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: canwire-entry-points\nVersion: 0\n")
    (info / "entry_points.txt").write_text("\n".join(["[can.interface]", *lines, ""]))
    return str(place)
