"""docs/web.md's terminal: the address that it shows is printed, and opened in the browser."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from html import unescape
from pathlib import Path

import pytest

from tests.docs.blocks import ROOT, blocks
from tests.hubs import LONG_S, serving

pytest.importorskip("starlette")
pytest.importorskip("uvicorn")
PAGE = ROOT / "docs" / "web.md"
BROWSER = """#!/bin/sh
cat "${1#file://}" > "$0.opened"
"""


def test_the_terminal_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`pip install` is for CI's own steps."""
    (console,) = [block.text for block in blocks(PAGE) if block.language == "console"]
    install, serve, web, shown = console.splitlines()
    assert (install, serve) == ("$ pip install 'canwire[web]'", "$ canwire serve &")
    browser = tmp_path / "browser"
    browser.write_text(BROWSER)
    browser.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    with serving(tmp_path, time="real") as served:
        monkeypatch.setenv("CANWIRE_HUB", served.address)
        command = [sys.executable, "-m", *web.removeprefix("$ ").split()]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            printed = process.stdout.readline()
            process.send_signal(signal.SIGTERM)
            assert process.wait(LONG_S) == 0
    form = re.escape(shown).replace("7457", r"\d+").replace("x6Fd…", r"\S+")
    assert re.fullmatch(form, printed.rstrip("\n"))
    assert printed.removeprefix("canwire web: ").strip() in unescape(Path(f"{browser}.opened").read_text())
