"""Prints how much each extra of canwire takes: the installed packages that it brings, with all that they need.

    python docs/extra_sizes.py

It counts the files of packages that are installed beside it, so it is run where canwire[all] is. The figures are in
docs/install.md.
"""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from packaging.requirements import Requirement

EXTRAS = (
    "can", "lin", "hardware", "databases", "tools", "network", "arrays", "web", "protocols", "plot", "mf4", "parquet",
    "cluster", "query",
)  # fmt: skip


def needed(name: str, extras: frozenset[str], found: dict[str, set[str]]) -> None:
    """Add a package with these extras, and what it requires, to what was found."""
    known = found.setdefault(name.lower().replace("_", "-"), set())
    if known >= extras | {""}:
        return
    known |= extras | {""}
    for text in distribution(name).requires or []:
        requirement = Requirement(text)
        marks = [{"extra": extra} for extra in (*extras, "")]
        if requirement.marker is None or any(requirement.marker.evaluate(mark) for mark in marks):
            needed(requirement.name, frozenset(requirement.extras), found)


def size_of(name: str) -> int:
    """Bytes of a package's files, compiled Python left out; canwire's own count as nothing."""
    files = [] if name == "canwire" else distribution(name).files or []
    paths = [Path(str(file.locate())) for file in files if file.suffix != ".pyc"]
    return sum(path.stat().st_size for path in paths if path.exists())


def main() -> None:
    for name, extras in [("none", []), *((extra, [extra]) for extra in EXTRAS), ("all", EXTRAS)]:
        found: dict[str, set[str]] = {}
        try:
            needed("canwire", frozenset(extras), found)
        except PackageNotFoundError as error:
            print(f"{name}: {error.name} is not installed")
            continue
        packages = sorted(set(found) - {"canwire"})
        print(f"{name}: {sum(map(size_of, packages)) / 1e6:.0f} MB, {len(packages)} packages")


if __name__ == "__main__":
    main()
