"""The suite passes wherever it is started: with signals ignored, and where packages are missing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

from tests import missing
from tests.conftest import hear_signals

ENDS_ITSELF = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\nprint('deaf')"


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_programs_hear_signals_that_are_ignored_here() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        hear_signals()
        os.kill(os.getpid(), signal.SIGINT)  # which goes on being nothing to this process
        ended = subprocess.run([sys.executable, "-c", ENDS_ITSELF], capture_output=True, text=True)
    finally:
        signal.signal(signal.SIGINT, before)
    assert (ended.returncode, ended.stdout) == (-signal.SIGINT, "")


def skipped(reason: str) -> pytest.TestReport:
    return pytest.TestReport("a test", ("a file", 1, ""), {}, "skipped", ("a file", 1, reason), "setup")


@pytest.mark.parametrize(
    ("reason", "allowed"),
    [
        (f"Skipped: {missing.reason('candump')}", False),
        ("Skipped: could not import 'cantools': No module named 'cantools'", False),
        ("Skipped: root may open everything", True),
    ],
)
def test_a_missing_package_fails_where_no_skip_is_allowed(
    reason: str, allowed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(missing, "FAIL", False)
    assert missing.judged(skipped(reason)).outcome == "skipped"
    monkeypatch.setattr(missing, "FAIL", True)
    report = missing.judged(skipped(reason))
    assert report.outcome == ("skipped" if allowed else "failed")
    assert allowed or reason in report.longreprtext
