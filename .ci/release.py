"""Makes a release of what is here: its version and its changes get a heading with a date in CHANGELOG.md.

    python .ci/release.py 0.3.0

Afterwards: read the diff, commit it, run `bash .ci/run`, tag the commit with v0.3.0, and build by `bash .ci/wheels`.
CONTRIBUTING.md says what a release checks.
"""

from __future__ import annotations

import datetime
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VERSION = re.compile(r"\d+\.\d+\.\d+")
FIRST_HEADING = re.compile(r"^## ", re.MULTILINE)


def fragments(root: Path) -> list[Path]:
    """The changes that no release has yet."""
    return sorted(path for path in (root / "changes").glob("*.md") if path.name != "README.md")


def release(root: Path, version: str, date: str) -> None:
    """Change the files below `root`; SystemExit, with nothing changed, where there is nothing to release."""
    if VERSION.fullmatch(version) is None:
        raise SystemExit(f"{version!r}: a version is three numbers, such as 0.3.0")
    parts = fragments(root)
    if not parts:
        raise SystemExit(f"{root / 'changes'}: no change to release")
    texts = [part.read_text(encoding="utf-8").strip("\n") for part in parts]
    for part, text in zip(parts, texts, strict=True):
        if not text.startswith("- "):
            raise SystemExit(f"{part}: its first line begins with '- '")
    log = root / "CHANGELOG.md"
    old = log.read_text(encoding="utf-8")
    if f"## {version} " in old:
        raise SystemExit(f"{log}: {version} is there already")
    heading = FIRST_HEADING.search(old)
    at = len(old) if heading is None else heading.start()
    entry = f"## {version} - {date}\n\n" + "\n".join(texts) + "\n\n"
    log.write_text(old[:at] + entry + old[at:], encoding="utf-8", newline="\n")
    module = root / "src" / "canwire" / "version.py"
    text = re.sub(r'__version__ = ".*"', f'__version__ = "{version}"', module.read_text(encoding="utf-8"))
    module.write_text(text, encoding="utf-8", newline="\n")
    for part in parts:
        part.unlink()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise SystemExit("one argument: the version, such as 0.3.0")
    release(ROOT, sys.argv[1], datetime.date.today().isoformat())
