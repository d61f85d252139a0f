"""Checks the built site: every link inside it leads somewhere, and five pages fit a phone and a desk.

    python docs/check_site.py build/site

Links: files and anchors of all pages. Layout: chromium lays five pages out at two widths, in frames of one page; none
may be wider than its window, and its navigation has to be seen. Without chromium only links are checked, unless
CANWIRE_MISSING=fail.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

PAGES = ("index", "install", "tutorials/shared-boards", "api/can-node", "verbs")
WIDTHS = (390, 1280)
HEIGHT = 900
LIMIT_S = 120
_OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files", "--virtual-time-budget=20000",
)  # fmt: skip
_MEASURED = re.compile(r'<pre id="measured">(.*?)</pre>', re.DOTALL)
_FRAMES = """<!doctype html><meta charset="utf-8"><body><pre id="measured"></pre><script>
const wanted = %s, found = [];
for (const [name, url, width] of wanted) {
  const frame = document.createElement("iframe");
  frame.style.cssText = `width:${width}px;height:%dpx;border:0`;
  frame.onload = () => {
    const page = frame.contentDocument, root = page.documentElement;
    const seen = (selector) => [...page.querySelectorAll(selector)].some((one) => {
      const box = one.getBoundingClientRect();
      return box.width > 0 && box.height > 0 && box.left < width && box.right > 0;
    });
    found.push([name, width, root.scrollWidth, seen(".sidebar-tree a, .mobile-header label"), seen("h1")]);
    document.getElementById("measured").textContent = JSON.stringify(found);
  };
  frame.src = url;
  document.body.append(frame);
}
</script>"""


class Page(HTMLParser):
    """What a page links to, and where it can be linked to."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name == "id" and value:
                self.anchors.add(value)
            elif name in ("href", "src") and value and tag in ("a", "img", "link", "script"):
                self.links.append(value)


def dead_links(site: Path) -> Iterator[str]:
    """PAGE: LINK for each that leads nowhere in the site; other sites are not asked."""
    pages = {path: parsed(path) for path in sorted(site.rglob("*.html")) if "_static" not in path.parts}
    for path, page in pages.items():
        for link in page.links:
            split = urlsplit(link)
            if split.scheme or split.netloc or (not split.path and not split.fragment):
                continue
            target = (path.parent / unquote(split.path)).resolve() if split.path else path
            wanted = unquote(split.fragment)
            missing = not target.exists()
            if missing or (wanted and target in pages and wanted not in pages[target].anchors):
                yield f"{path.relative_to(site)}: {link}"


def parsed(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def misfits(site: Path, chromium: str) -> Iterator[str]:
    """Pages that are wider than their window, or whose navigation or heading nobody sees."""
    wanted = [(page, (site / f"{page}.html").as_uri(), width) for page in PAGES for width in WIDTHS]
    with tempfile.TemporaryDirectory() as folder:
        frames = Path(folder) / "frames.html"
        frames.write_text(_FRAMES % (json.dumps(wanted), HEIGHT), encoding="utf-8")
        profile = f"--user-data-dir={folder}/profile"
        command = [chromium, *_OPTIONS, profile, "--dump-dom", frames.as_uri()]
        shown = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    text = _MEASURED.search(shown.stdout)
    rows = json.loads(unescape(text[1])) if text is not None and text[1] else []
    if len(rows) != len(wanted):
        yield f"{len(rows)} of {len(wanted)} pages were laid out: {shown.stderr[-300:]}"
    for page, width, wide, navigation, heading in rows:
        if wide > width:
            yield f"{page}: {wide} pixels wide in a window of {width}"
        if not navigation:
            yield f"{page}: no navigation in a window of {width} pixels"
        if not heading:
            yield f"{page}: no heading in a window of {width} pixels"


def main() -> int:
    if len(sys.argv) != 2:
        raise SystemExit("one argument: the folder of the built site")
    site = Path(sys.argv[1]).resolve()
    faults = list(dead_links(site))
    chromium = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if chromium is not None:
        faults += misfits(site, chromium)
    elif os.environ.get("CANWIRE_MISSING") == "fail":
        faults.append("chromium is not installed")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
