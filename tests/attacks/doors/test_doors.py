"""Whatever is handed to whatever is public: canwire's errors, TypeError, ValueError with a sentence; never a signal."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import canwire
from tests.cases import each
from tests.hubs import LONG_S

ROOT = Path(__file__).parents[3]
HOME = Path(str(canwire.__file__)).parents[1]
FROM_SOURCES = f"""
import runpy, sys
from pathlib import Path
from tests.uncompiled import SourcesOnly
sys.meta_path.insert(0, SourcesOnly("canwire", Path({str(HOME)!r})))
runpy.run_module("tests.attacks.doors.walk", run_name="__main__", alter_sys=True)
"""


@pytest.mark.finding("faults 1", "faults 9")
@pytest.mark.parametrize("form", ["installed", "uncompiled"])
def test_nothing_public_answers_otherwise(form: str, tmp_path: Path) -> None:
    report = tmp_path / "report.jsonl"
    how = ["-c", FROM_SOURCES] if form == "uncompiled" else ["-m", "tests.attacks.doors.walk"]
    mode = "uncompiled" if form == "uncompiled" else canwire.core_mode()
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", *how, str(report)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": f"{HOME}{os.pathsep}{ROOT}", "CANWIRE_EXPECT": mode},
        capture_output=True,
        text=True,
        timeout=10 * LONG_S,
    )
    under_way = Path(f"{report}.now").read_bytes().strip(b"\0 ").decode()
    wrong = [json.loads(line) for line in report.read_text().splitlines()]
    assert (under_way, wrong) == ("", [])
    assert (done.returncode, done.stderr) == (0, "")
    calls = int(done.stdout.split()[0])
    assert calls > 15_000


@pytest.mark.finding("faults 1")
def test_what_a_receive_that_timed_out_gave_cannot_be_sent_on() -> None:
    with canwire.connect(time="virtual") as hub:
        place = canwire.find_lines(hub, "can0")[0]
        mode = canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=8_000_000))
        with canwire.start_line(hub, place, mode), hub.open_channel(place.board.id, place.line) as channel:
            channel.set_up(canwire.ChannelMode(receive=16, transmit=16))
            channel.activate()
            nothing = channel.receive(timeout=0)
            with pytest.raises(TypeError, match="frame None: must be Frame, not NoneType"):
                channel.send(nothing)  # type: ignore[arg-type]
            assert channel.status().sent == 0


@pytest.mark.finding("faults 8")
@each("records", [[1, 2], np.zeros(3), np.zeros((2, 2), canwire.record_dtype())])
def test_only_rows_of_records_are_sent(records: object) -> None:
    with canwire.Lab() as lab:
        node = lab.can_bus("can0").node("engine")
        with pytest.raises(TypeError, match="records"):
            node.send_array(records)  # type: ignore[arg-type]
        assert node.sent == 0
