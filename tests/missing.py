"""Tests that are skipped for want of a package; with CANWIRE_MISSING=fail they fail instead, and say which it is.

Optional packages of pip are asked for with pytest.importorskip, programs with `needs_program`, `find_program` or
`find_browser`.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from typing import TypeVar

import pytest

from canwire import Unsupported

Found = TypeVar("Found")
Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)

FAIL = os.environ.get("CANWIRE_MISSING") == "fail"
_REASONS = ("could not import", "not installed")  # pytest.importorskip's, and ours
PACKAGES = {
    "x86_64-w64-mingw32-g++": "g++-mingw-w64-x86-64-win32",
    "candump": "can-utils",
    "cansend": "can-utils",
    "log2long": "can-utils",
    "go": "golang-go",
    "ip": "iproute2",
    "mcs": "mono-mcs",
    "mono": "mono-runtime",
    "musl-gcc": "musl-tools",
}  # else named as the program


def reason(program: str) -> str:
    """Why a test is skipped where this program is not."""
    return f"{program} is not installed (apt-get install {PACKAGES.get(program, program)})"


def needs_program(program: str) -> pytest.MarkDecorator:
    """A mark: skipped where this program is not installed."""
    return pytest.mark.skipif(shutil.which(program) is None, reason=reason(program))


def not_on_windows(why: str) -> pytest.MarkDecorator:
    """A mark: skipped on Windows, for this reason."""
    return pytest.mark.skipif(os.name == "nt", reason=f"Windows {why}")


def find_program(program: str) -> str:
    """The path of this program; where it is not installed, the test is skipped."""
    found = shutil.which(program)
    if found is None:
        pytest.skip(reason(program))
    return found


def supported(call: Callable[[], Found]) -> Found:
    """What this returns; where this system or installation has no such thing, the test is skipped."""
    try:
        return call()
    except Unsupported as error:
        pytest.skip(str(error))


def find_browser() -> str:
    """The path of Debian's chromium, rather the one without windows, which takes a fifth less of the processor."""
    return shutil.which("chromium-headless-shell") or find_program("chromium")


def judged(report: Report) -> Report:
    """The report; a skip for want of a package becomes a failure where none is allowed."""
    if FAIL and report.skipped and isinstance(report.longrepr, tuple):
        why = report.longrepr[2]
        if any(text in why for text in _REASONS):
            report.outcome = "failed"
            report.longrepr = f"CANWIRE_MISSING=fail allows no skip: {why}"
    return report
