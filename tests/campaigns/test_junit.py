"""A campaign as JUnit XML: counts, a case a run, the trace and the line to repeat it; legal XML whatever is said."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from canwire import BadValue, run_campaign
from tests.campaigns.scripts import WILD, written

pytestmark = pytest.mark.usefixtures("warm_workers")

SAYS = """
from canwire import campaign


@campaign(what=["well", "late", "odd", "gone"])
def says(lab, what):
    print("this is", what)
    if what == "late":
        assert False, "5 ms <late> & more"
    if what == "odd":
        raise ValueError("a bell \\a, a half \\udc80 and no character \\uffff")
    if what == "gone":
        import os
        os.abort()
"""


@pytest.mark.conforms("N-37")
def test_each_run_is_a_case(tmp_path: Path) -> None:
    path, report = written(tmp_path, "says.py", SAYS), tmp_path / "out.xml"
    runs = run_campaign(path, runs=8, seed=3, workers=1, report=report)
    root = ElementTree.parse(report).getroot()
    suite = root.find("testsuite")
    assert suite is not None
    assert [suite.get(key) for key in ("name", "tests", "failures", "errors")] == ["says", "8", "2", "4"]
    assert float(suite.get("time", "")) == pytest.approx(sum(run.wall_s for run in runs), abs=1e-5)
    cases = list(suite.iter("testcase"))
    assert [case.get("name") for case in cases[:2]] == ["run 0 what=well", "run 1 what=late"]
    assert {case.get("classname") for case in cases} == {"says.says"}
    assert [[child.tag for child in case] for case in cases[:4]] == [
        ["system-out"], ["failure", "system-out"], ["error", "system-out"], ["error", "system-out"],
    ]  # fmt: skip
    failure, odd, gone = cases[1][0], cases[2][0], cases[3][0]
    assert failure.get("message") == "5 ms <late> & more"
    assert "AssertionError" in (failure.text or "")
    assert (failure.text or "").endswith(f"repeat it: canwire campaign {path} --seed 3 --repeat 1")
    assert odd.get("message") == r"ValueError: a bell \x07, a half \udc80 and no character \uffff"
    assert (gone.get("type"), "Aborted" in (gone.text or "")) == ("crashed", True)
    assert cases[0][0].text == "this is well\n"
    assert not list(tmp_path.glob("*.part"))


def test_what_was_done_is_reported_after_ctrl_c(tmp_path: Path) -> None:
    def stop(run: object) -> None:
        raise KeyboardInterrupt

    path, report = written(tmp_path, "says.py", SAYS), tmp_path / "out.xml"
    with pytest.raises(KeyboardInterrupt):
        run_campaign(path, workers=1, report=report, told=stop)
    assert [case.get("name") for case in ElementTree.parse(report).iter("testcase")] == ["run 0 what=well"]


def test_a_report_that_cannot_be_written_is_refused_before_anything_is_played(tmp_path: Path) -> None:
    path = written(tmp_path, "wild.py", WILD.replace("WAYS", "['nothing']"))
    with pytest.raises(BadValue, match=r"ends in \.xml"):
        run_campaign(path, report=tmp_path / "out.txt")
    with pytest.raises(FileNotFoundError):
        run_campaign(path, report=tmp_path / "nowhere" / "out.xml")
    assert not (tmp_path / "played").exists()
