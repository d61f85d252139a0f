"""The fixtures, and what a failing test shows: by running tests inside tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from canwire import Frame, Lab, LabBus, NodeScript, NotReceived

pytest_plugins = ["pytester"]
pytestmark = pytest.mark.conforms("PL-05")


@pytest.fixture
def inner(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """Where the entry point, if there is one, does not load the plugin: `run` does."""
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return pytester


def run(inner: pytest.Pytester, source: str) -> pytest.RunResult:
    inner.makepyfile(source)
    return inner.runpytest("-p", "canwire.pytest_plugin", "-p", "no:cacheprovider")


def section(result: pytest.RunResult, name: str) -> list[str]:
    """The lines under a section's title."""
    lines = result.outlines
    start = next(k for k, line in enumerate(lines) if line.strip("- ") == name) + 1
    end = next(k for k in range(start, len(lines)) if lines[k].startswith(("----", "====", "____")))
    return lines[start:end]


def test_a_lab_in_virtual_time(lab: Lab) -> None:
    assert (lab.now_ns, lab.buses, lab.pacer) == (0, {}, None)
    lab.run_for(3600.0)
    assert lab.now_ns == 3600 * 10**9


def test_a_bus_for_classic_and_fd(can_bus: LabBus, lab: Lab) -> None:
    assert lab.buses == {"can0": can_bus}
    assert can_bus.data_timing is not None
    assert (can_bus.timing.bit_rate, can_bus.data_timing.bit_rate) == (500_000, 2_000_000)


class Ecu(NodeScript):
    """Answers a request for the vehicle's speed."""

    def on_message(self, frame: Frame) -> None:
        if frame.data[:3] == b"\x02\x01\x0d":
            self.send(Frame(0x7E8, b"\x03\x41\x0d\x32"))


def test_expectations(can_bus: LabBus) -> None:
    can_bus.node("ecu", Ecu())
    tester = can_bus.node("tester")
    tester.send(Frame(0x7DF, b"\x02\x01\x0d"))
    assert tester.expect(0x7E8, within=0.01).data[3] == 0x32
    tester.expect_nothing(within=1.0)
    tester.send(Frame(0x7DF, b"\x02\x01\x0d"))
    with pytest.raises(NotReceived, match=r"no frame 0x7e9 within 0\.01 s; 1 others, last: Frame\(0x7E8"):
        tester.expect(0x7E9, within=0.01)
    tester.send(Frame(0x7DF, b"\x02\x01\x0d"))
    with pytest.raises(NotReceived, match="arrived where silence was expected"):
        tester.expect_nothing(within=0.01)


def test_each_test_has_its_own_bus(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        import canwire
        kept = []
        def test_one(can_bus, lab):
            can_bus.node("a").send(canwire.Frame(1))
            lab.run_for(0.001)
            kept.append((lab, can_bus))
        def test_other(can_bus, lab):
            assert can_bus is not kept[0][1] and not can_bus.nodes and lab.now_ns == 0
            try:
                kept[0][0].run_for(1)
            except canwire.Closed:
                return
            assert False, "the first test's lab is still open"
        """,
    )
    result.assert_outcomes(passed=2)


def test_what_a_test_had_does_not_stay_in_memory(inner: pytest.Pytester) -> None:
    """Pytest keeps all tests to the end of the session: with their labs a long one took hundreds of megabytes."""
    result = run(
        inner,
        """
        import gc, weakref
        had = []
        def test_one(can_bus, lin_bus, lab, canwire_hub):
            had.extend(map(weakref.ref, (can_bus, lin_bus, lab, canwire_hub)))
        def test_other(lab):
            gc.collect()
            assert [one() for one in had] == [None] * 4
        """,
    )
    result.assert_outcomes(passed=2)


def test_failure_shows_the_bus(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        from canwire import parse_frame
        def test_it(can_bus, lab):
            a, b = can_bus.node("engine"), can_bus.node("tester", receive_queue=2)
            a.send_many(map(parse_frame, ["123#1122", "12345678##1AABB", "123#R", "124#"]))
            lab.run_until_idle()
            can_bus.faults.flip(frame_id=0x300, bit=20, seen_by="sender")
            a.send(parse_frame("300#00"))
            lab.run_until_idle()
            b.send(parse_frame("7FF#"))
            assert b.receive(timeout=0.0) is None
        """,
    )
    result.assert_outcomes(failed=1)
    shown = section(result, "canwire: can0")
    assert shown[0] == " (0000000000.000124)  can0  123   [2]  11 22  ; engine"
    assert [line.split()[2] for line in shown[:5]] == ["123", "12345678", "123", "124", "300"]
    assert shown[2].endswith("remote request  ; engine")
    assert shown[5:] == [
        "engine: ERROR_ACTIVE, TEC 7, REC 0, lost 0, 0 waiting, 0 to send",
        "tester: ERROR_ACTIVE, TEC 0, REC 0, lost 3, 1 waiting, 1 to send",
    ]


def test_failure_shows_the_last_hundred_frames_of_every_bus(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        from canwire import Frame
        def test_it(lab, can_bus):
            other = lab.can_bus("comfort", bit_rate=125_000)
            a, b = other.node("door"), other.node("seat")
            a.send_many(Frame(0x100, k.to_bytes(2, "big")) for k in range(150))
            lab.run_until_idle()
            assert False
        """,
    )
    assert section(result, "canwire: can0") == ["no frame got through"]
    shown = section(result, "canwire: comfort")
    assert len(shown) == 102
    assert "00 32  ; door" in shown[0]
    assert "00 95  ; door" in shown[99]


@pytest.mark.finding("newcomer F12")
def test_a_lin_bus_and_what_was_on_it(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        def test_it(lin_bus, lab):
            slave = lin_bus.slave("door", responses={0x11: b"\\x01\\x02"})
            master = lin_bus.master()
            master.ask(0x11)
            assert master.expect(0x11, within=0.1).data == b"\\x01\\x02"
            assert False
        """,
    )
    result.assert_outcomes(failed=1)
    shown = section(result, "canwire: lin0")
    assert shown[0].endswith("lin0 11#0102  ; door")
    assert [line.split(",")[0] for line in shown[1:]] == ["door: OPERATIONAL", "master: OPERATIONAL"]


@pytest.mark.finding("newcomer F12")
def test_long_names_are_the_same_fixtures(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        def test_it(lab, can_bus, lin_bus, canwire_lab, canwire_bus, canwire_lin_bus):
            assert (lab, can_bus, lin_bus) == (canwire_lab, canwire_bus, canwire_lin_bus)
            assert lab.buses == {"can0": can_bus} and lab.lin_buses == {"lin0": lin_bus}
        """,
    )
    result.assert_outcomes(passed=1)


@pytest.mark.finding("newcomer F12")
def test_short_names_can_be_left_to_others(inner: pytest.Pytester) -> None:
    inner.makeini("[pytest]\ncanwire_short_fixtures = false\n")
    result = run(
        inner,
        """
        def test_long(canwire_bus, canwire_lin_bus):
            assert (canwire_bus.name, canwire_lin_bus.name) == ("can0", "lin0")
        def test_short(can_bus): pass
        """,
    )
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*fixture 'can_bus' not found*"])


def test_failing_setup_shows_the_bus(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        import pytest
        from canwire import Frame
        @pytest.fixture
        def running(can_bus, lab):
            can_bus.node("a").send(Frame(0x123))
            can_bus.node("b").expect(0x124, within=0.1)
        def test_it(running): pass
        """,
    )
    result.assert_outcomes(errors=1)
    assert section(result, "canwire: can0")[0].endswith("; a")


def test_passing_and_other_tests_show_nothing(inner: pytest.Pytester) -> None:
    result = run(
        inner,
        """
        def test_passes(can_bus): pass
        def test_fails(): assert False
        """,
    )
    result.assert_outcomes(passed=1, failed=1)
    result.stdout.no_fnmatch_line("*canwire: *")


def test_found_by_its_entry_point_and_by_our_conftest_alike(tmp_path: Path) -> None:
    """As installed, alone and where a conftest like ours registers it too: once, without a complaint."""
    info = tmp_path / "site" / "canwire-0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: canwire\nVersion: 0\n")
    (info / "entry_points.txt").write_text("[pytest11]\ncanwire = canwire.pytest_plugin\n")
    conftest = (Path(__file__).parent / "conftest.py").read_text()
    for name, text in (("installed", ""), ("ours", conftest)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "conftest.py").write_text(text)
        (folder / "test_it.py").write_text("def test_it(can_bus): assert can_bus.name == 'can0'\n")
        _run_apart(folder, tmp_path / "site")


def _run_apart(folder: Path, site: Path) -> None:
    program = (
        "import importlib.metadata, sys, pytest\n"
        "known = importlib.metadata.entry_points(group='pytest11').names\n"
        f"'canwire' in known or sys.path.insert(0, {str(site)!r})\n"
        "quiet = ['-q', '-W', 'error', '-p', 'no:cacheprovider', '-p', 'no:asyncio']\n"
        "sys.exit(pytest.main([*quiet, '--rootdir', '.', '.']))\n"
    )
    quiet = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=folder,
        env={**quiet, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert (done.returncode, "1 passed" in done.stdout) == (0, True), done.stdout + done.stderr
