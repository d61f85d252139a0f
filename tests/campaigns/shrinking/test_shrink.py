"""Runs whose causes are known, on real buses: what is left is that cause, and the line plays it once more."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import BadValue, SmallestCause, repeat_run, run_campaign, shrink_run
from canwire.campaigns.batches import Rules
from canwire.campaigns.change import Change
from canwire.campaigns.junit import Played
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, Order, play
from canwire.campaigns.shrinking.shrink import _Search
from canwire.campaigns.shrinking.trials import Trials
from canwire.commands import main
from tests.campaigns.scripts import written

pytestmark = [pytest.mark.conforms("N-60"), pytest.mark.usefixtures("warm_workers")]

HEAD = """
import os
from canwire import Draw, Frame, campaign


def bench(lab, rate=500_000):
    bus = lab.can_bus(bit_rate=rate)
    return bus, bus.node("a"), bus.node("b")

"""
FLIPS = '''
@campaign(rate=[500_000, 250_000, 125_000], frames=Draw.integer(12, 40))
def flips(lab, rate, frames):
    """Two errors in a row of frame 0x107 make the receiver late; the other faults do no harm."""
    bus, a, b = bench(lab, rate)
    for id in range(0x100, 0x110):
        bus.faults.flip(bit=25, frame_id=id)
    bus.faults.flip(bit="ack", frame_id=0x107)
    bus.faults.disconnect(bus.node("c"))
    for number in range(frames):
        a.send(Frame(0x100 + number, bytes([number])))
        lab.run_for(0.01)
    assert not any(frame.id == 0x107 and bus.error_frames for frame in b.receive_many(1000)), "0x107 is late"
'''
NOISE = '''
@campaign(rate=[500_000])
def noisy(lab, rate):
    """Any error is one too many."""
    bus, a, b = bench(lab)
    bus.faults.noise(2e-3)
    a.send_array(__import__("canwire").frames_to_array([Frame(0x100 + n, bytes(8)) for n in range(30)]))
    lab.run_until_idle()
    assert bus.error_frames == 0
'''
ENDS = '''
@campaign(number=range(4))
def ends(lab, number):
    """The process ends at the third frame that is received, if 0x20 is among them."""
    bus, a, b = bench(lab)
    for id in range(0x18, 0x28):
        a.send(Frame(id))
    lab.run_until_idle()
    ids = [frame.id for frame in b.receive_many(100)]
    if 0x20 in ids and len(ids) > 2:
        os.abort()
'''
ASKS = '''
@campaign(number=[1])
def asks(lab, number):
    """Without its question it would wait for ever: a trial of that is given up by the lab's time."""
    bus, a, b = bench(lab)
    a.send(Frame(0x10))
    a.send(Frame(0x11))
    while b.receive(0.001) is None:
        pass
    raise KeyError(number)
'''


class Here(Trials):
    """Trials in this process."""

    def _played(self, order: Order) -> CampaignRun:
        return play(self.script.load(), order, self.rules.seed, limit_s=self.rules.limit_s)


def smallest(folder: Path, text: str, number: int, most: int = 500) -> SmallestCause:
    script = Script.read(written(folder, "some.py", HEAD + text))
    made = script.load()
    search = _Search(Here(script, Rules(1), most), made, Played(script.path, made.name, 1))
    return search.found(number)


def test_faults_frames_and_values_that_do_no_harm_are_left_out(tmp_path: Path) -> None:
    found = smallest(tmp_path, FLIPS, 2)
    assert found.given == {"rate": 500_000, "frames": 12}
    assert (found.only["frames"], len(found.only["faults"])) == ((7,), 1)
    assert found.run.place == "AssertionError in flips, line 22 of some.py"
    assert found.run.error_frames == 1
    assert found.words[0] == "frames 7: can0/a: 107#07"
    assert "frame_id=263" in found.words[1]
    assert found.complete
    assert smallest(tmp_path, FLIPS, 2) == found
    again, log = repeat_run(tmp_path / "some.py", 2, given=found.given, only=found.only)
    assert (again, len(log)) == (found.run, 1)


def test_one_bit_of_noise_is_left(tmp_path: Path) -> None:
    pytest.importorskip("numpy")
    found = smallest(tmp_path, NOISE, 0)
    assert [len(found.only[kind]) for kind in ("frames", "noise", "faults")] == [1, 0, 0]
    assert found.run.error_frames == len(found.flips) == 1
    (number,) = found.only["frames"]
    assert found.flips[0].startswith(f"can0:{0x100 + number:03X}:"), "a bit of that frame"
    assert repeat_run(tmp_path / "some.py", 0, only=found.only, flips=found.flips)[0] == found.run


def test_a_trial_without_end_is_given_up_by_the_time_of_its_lab(tmp_path: Path) -> None:
    found = smallest(tmp_path, ASKS, 0)
    assert len(found.only["frames"]) == 1
    assert found.run.place == "KeyError in asks, line 19 of some.py"


def test_no_more_trials(tmp_path: Path) -> None:
    found = smallest(tmp_path, FLIPS, 2, most=6)
    assert (found.trials, found.complete) == (6, False)
    assert "no trial was left" in str(found)
    assert not found.run.passed


def test_a_run_that_passes_has_no_cause(tmp_path: Path) -> None:
    with pytest.raises(BadValue, match="run 0 with seed 1 passes"):
        smallest(tmp_path, FLIPS.replace("0x107 and", "0x0 and"), 0)
    with pytest.raises(BadValue, match="run's parameters are rate, frames"):
        repeat_run(tmp_path / "some.py", 0, given={"speed": 1})


def test_a_run_that_ends_its_process(tmp_path: Path) -> None:
    found = shrink_run(written(tmp_path, "some.py", HEAD + ENDS), 3)
    assert found.given == {"number": 0}
    assert len(found.only["frames"]) == 3
    assert 8 in found.only["frames"]
    assert found.run.place == "crash in ends, line 20 of some.py"
    assert "--repeat 3 --set number=0 " in found.line


def test_the_verb_and_the_reports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, "some.py", HEAD + FLIPS)
    report = tmp_path / "out.html"
    assert main(["campaign", str(path), "--workers", "1", "--shrink", "--report", str(report)]) == 1
    lines = capsys.readouterr().out.splitlines()
    (line,) = [one for one in lines if "--only" in one]
    assert line in report.read_text()
    assert main(line.split()[1:]) == 1
    assert "1 frames, 1 error frames" in capsys.readouterr().out
    assert main(["campaign", str(path), "--only", "frames=1"]) == 2
    assert "--repeat" in capsys.readouterr().err


def test_the_cause_is_in_its_run_alone(tmp_path: Path) -> None:
    path = written(tmp_path, "some.py", HEAD + FLIPS)
    runs = run_campaign(path, workers=1, shrink=10, report=tmp_path / "out.xml")
    assert [bool(run.smallest) for run in runs] == [True, False, False]
    assert "found by 10 runs" in (tmp_path / "out.xml").read_text()


def test_changes_do_not_touch_a_run_without_them(tmp_path: Path) -> None:
    """A lab that asks about everything and leaves nothing out plays the same run."""
    campaign = Script.read(written(tmp_path, "some.py", HEAD + FLIPS)).load()
    assert play(campaign, Order(1, Change()), 7) == play(campaign, Order(1), 7)
