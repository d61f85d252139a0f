"""`canwire timing`, and the frame around every verb."""

from __future__ import annotations

import json
import re
import subprocess
import sys

import pytest

from canwire.commands import VERBS, main
from tests import warm
from tests.cases import each


def lines(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return capsys.readouterr().out.splitlines()


@pytest.mark.smoke
@pytest.mark.conforms("PL-06")
def test_from_a_bit_rate(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "500000"]) == 0
    assert lines(capsys) == [
        "500000 bit/s from 8000000 Hz / 1",
        "  16 quanta of 125 ns: SYNC 1, PROP 11, PHASE1 2, PHASE2 2; SJW 1",
        "  sample point 87.50%, 1750 of 2000 ns",
        "  oscillators: 0.312% (condition 1 0.312%, condition 2 0.485%)",
        "  SJA1000 at 16000000 Hz: BTR0 00, BTR1 1C",
    ]


@pytest.mark.conforms("PL-06")
def test_from_a_sample_point(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "1000000", "--sample-point", "87.5", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["nominal"]
    assert (found["sample_point"], found["btr"]) == (0.875, "0005")


@pytest.mark.conforms("PL-06")
def test_from_registers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "--btr", "3F7F", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["nominal"]
    assert (found["bit_rate"], found["sample_point"], found["quanta"]) == (5_000, 0.68, 25)
    assert main(["timing", "--btr", "001c", "--clock", "12000000"]) == 0
    assert lines(capsys)[0] == "750000 bit/s from 12000000 Hz / 1"


@pytest.mark.conforms("PL-06")
def test_list_of_solutions_per_clock(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "500000", "--list", "--sample-point", "75"]) == 0
    listed = lines(capsys)
    assert len(listed) == 14
    assert "sample  75.00%" in listed[0]
    assert main(["timing", "500000", "--list", "--clock", "12000000"]) == 0
    assert len(lines(capsys)) > 14


@pytest.mark.conforms("PL-06")
def test_both_phases_of_an_fd_bus(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "500000", "--data-bit-rate", "2000000", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["nominal"][0]["bit_rate"] == 500_000
    assert found["data"][0]["bit_rate"] == 2_000_000
    assert sorted(found["fd_tolerance"]) == ["I", "II", "III", "IV", "V"]
    assert main(["timing", "500000", "--data-bit-rate", "2000000"]) == 0
    shown = lines(capsys)
    assert shown[0] == "nominal phase:"
    assert "data phase:" in shown
    assert shown[-1].startswith("oscillators: 0.296% (conditions I 0.625%")
    assert main(["timing", "500000", "--data-bit-rate", "2000000", "--list"]) == 0
    assert len(lines(capsys)) > 100


@pytest.mark.conforms("X4-19")
def test_search(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "500000", "--search", "--tolerance", "0.5", "--delay-ns", "300"]) == 0
    assert "PROP 3, PHASE1 6, PHASE2 6; SJW 3" in capsys.readouterr().out
    assert main(["timing", "500000", "--search", "--tolerance", "2"]) == 2
    assert "canwire: no solution for 500000 bit/s: PHASE1 6 is shorter" in capsys.readouterr().err


@each(
    ("words", "why"),
    [
        (["timing"], "give a bit rate"),
        (["timing", "500000", "--btr", "001C"], "not both"),
        (["timing", "--btr", "1C"], "four hex digits"),
        (["timing", "--btr", "xxxx"], "four hex digits"),
        (["timing", "700000"], "nearest: 666667 and 727273"),
        (["timing", "500000", "--sjw", "9"], "sjw 9"),
        (["timing", "500000", "--sample-point", "0"], "sample_point 0"),
        (["timing", "500000", "--controller", "sja1000", "--data-bit-rate", "2000000"], "no data phase"),
    ],
)
def test_a_mistake_is_one_line_and_status_2(
    words: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("canwire: ")
    assert captured.err.count("\n") == 1
    assert why in captured.err


def test_help_lists_the_verbs_and_loads_none() -> None:
    program = (
        "import sys, canwire.commands as commands\n"
        "try: commands.main(['--help'])\n"
        "except SystemExit: pass\n"
        "verbs = {verb.module for verb in commands.VERBS.values()}\n"
        "assert not verbs & set(sys.modules)\n"
    )
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    for verb in VERBS:
        assert re.search(rf"^ +{verb}\b", shown.stdout, re.MULTILINE)


def test_version_says_which_core_runs(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out in (
        "canwire 0.2.0 (compiled core)\n",
        "canwire 0.2.0 (uncompiled core: slower)\n",
    )


def test_a_reader_that_leaves_is_no_error() -> None:
    process = warm.Popen(
        [sys.executable, "-m", "canwire", "timing", "5000", "--controller", "fd", "--list"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.readline()
    process.stdout.close()
    complaint = process.stderr.read()
    process.stderr.close()
    assert (process.wait(timeout=60), complaint) == (141, "")


def test_ctrl_c_is_quiet(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import canwire.commands.timing.verb as timing

    def interrupted(_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(timing, "run", interrupted)
    assert main(["timing", "500000"]) == 130
    assert capsys.readouterr().err == ""


def test_the_rate_may_be_an_option_as_other_verbs_have_it(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", "500000"]) == 0
    by_place = capsys.readouterr().out
    assert main(["timing", "--bit-rate", "500000"]) == 0
    assert capsys.readouterr().out == by_place
    assert main(["timing", "250000", "--bit-rate", "500000"]) == 2
    assert "two bit rates, 250000 and --bit-rate 500000" in capsys.readouterr().err


@pytest.mark.conforms("G-13")
@pytest.mark.parametrize(
    ("nodes", "status", "last"),
    [
        (
            ["500k@80/2M@80", "500k@80/2M@80"],
            0,
            "yes; the smallest margin: cable: 500 of 1600 ns, 1100 ns left",
        ),
        (
            ["500k@87.5/4M@80", "b=500k@75/4M@80"],
            1,
            "no: they would not understand each other (sample points)",
        ),
        (["1M@75", "1M@75", "--cable", "100"], 1, "no: they would not understand each other (cable)"),
        (
            ["500k@87.5", "500k@75", "--ppm", "2000", "--node-delay-ns", "0"],
            0,
            "yes; the smallest margin: oscillators: 0.4 of 0.9709 %, 0.5709 % left",
        ),
        (["btr:001C", "500k@87.5,1"], 0, "yes; the smallest margin: cable: 500 of 1750 ns, 1250 ns left"),
    ],
)
def test_whether_nodes_understand_each_other(
    nodes: list[str], status: int, last: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["timing", "--nodes", *nodes]) == status
    assert lines(capsys)[-1] == last
    assert main(["timing", "--json", "--nodes", *nodes]) == status
    found = json.loads(capsys.readouterr().out)
    assert found["understand"] is not bool(status)
    assert found["understand"] is not any(check["exceeded"] for check in found["checks"])


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--nodes", "fast"], "--nodes fast: RATE@PERCENT"),
        (["--nodes", "5"], "5 bit/s cannot be made"),
        (["500000", "--nodes", "500k"], "leave the bit rate and --btr out"),
        (["--nodes", "500k", "--cable", "-1"], "--cable -1.0: cannot be negative"),
    ],
)
def test_nodes_that_are_none(words: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["timing", *words]) == 2
    assert why in capsys.readouterr().err
