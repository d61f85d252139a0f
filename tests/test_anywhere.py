"""The suite passes wherever it is started: with signals ignored, and where packages are missing."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests import missing
from tests.cold import PYTEST
from tests.conftest import hear_signals
from tests.hubs import LONG_S

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


CHOSEN = """
import canwire
def test_it_finds_a_hub_of_this_process_as_usual():
    with canwire.connect() as hub:
        assert hub.address == ""
        assert hub.boards()
"""


@pytest.mark.skipif(not hasattr(socket, "AF_UNIX"), reason="hubs listen elsewhere there")
def test_what_a_user_has_chosen_and_runs_is_not_there(tmp_path: Path) -> None:
    """With CANWIRE_CONFIG set a thousand tests failed."""
    root = Path(__file__).parent
    (tmp_path / "test_chosen.py").write_text(CHOSEN)
    with socket.socket(socket.AF_UNIX) as theirs:
        theirs.bind(str(tmp_path / "canwire.sock"))
        theirs.listen()
        strange = {
            "CANWIRE_CONFIG": "/not/there.toml",
            "CANWIRE_HUB": "/not/there.sock",
            "XDG_RUNTIME_DIR": str(tmp_path),
        }
        command = [*PYTEST, "-n", "0", "--rootdir", str(tmp_path), "-c", os.devnull]
        done = subprocess.run(
            [*command, "-p", "tests.conftest", str(tmp_path / "test_chosen.py")],
            cwd=root.parent,
            env={**os.environ, **strange},
            capture_output=True,
            text=True,
            timeout=LONG_S,
        )
    assert done.returncode == 0, done.stdout + done.stderr


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
