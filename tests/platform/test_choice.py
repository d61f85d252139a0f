"""Which variant runs: the system's own, unless CANWIRE_PLATFORM says otherwise."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

ASK = "from canwire import platform; print(platform.PORTABLE, platform.EventDescriptor.__module__)"


def asked(value: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", ASK],
        env=os.environ | {"CANWIRE_PLATFORM": value},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


@pytest.mark.parametrize(
    ("value", "answer"),
    [("", "False canwire.platform.linux"), ("portable", "True canwire.platform.portable.events")],
)
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is one variant")
def test_it_is_asked_for(value: str, answer: str) -> None:
    assert asked(value).stdout.strip() == answer


def test_anything_else_is_refused() -> None:
    done = asked("windows")
    assert done.returncode != 0
    assert done.stderr.splitlines()[-1].endswith(
        "CANWIRE_PLATFORM=windows: portable, or leave it unset for the fastest means of this system"
    )
