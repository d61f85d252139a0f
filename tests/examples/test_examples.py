"""The programs in examples/ run as they stand, and find what they say."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests import warm
from tests.cases import each

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAMS = sorted(EXAMPLES.glob("*.py"))
MOST_LINES = 60


NEEDS = {"alive": "cantools", "iso_tp": "isotp", "lin_master": "ldfparser"}


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_each_runs_by_itself(path: Path) -> None:
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem])
    ended = warm.run([sys.executable, str(path)], capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout


@each("path", PROGRAMS, ids=lambda path: path.stem)
def test_each_is_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


def test_messages_are_counted_and_summed() -> None:
    pytest.importorskip("cantools")
    from examples import alive

    assert [line.split(", ", 3)[3] for line in alive.main()] == [
        f"Alive: {count}, Check: {200 + count})" for count in range(3)
    ]


def test_a_gateway_passes_on_what_it_should() -> None:
    from examples import gateway

    heard = gateway.main()
    assert [(frame.id, int.from_bytes(frame.data, "big")) for frame in heard] == [
        (0x500, 800 + 50 * number) for number in range(1, 6)
    ]


def test_the_alarm_comes_when_the_patience_is_over() -> None:
    from examples import heartbeat

    assert heartbeat.main() == pytest.approx(heartbeat.PATIENCE_S - heartbeat.PERIOD_S, abs=0.002)


def test_the_lowest_identifier_goes_first() -> None:
    from examples import arbitration

    assert arbitration.main() == ["brake", "engine", "door", "radio"]


def test_bus_off_and_back() -> None:
    from examples import bus_off

    assert bus_off.main() == [
        ("ERROR_ACTIVE", 8),
        ("ERROR_WARNING", 96),
        ("ERROR_PASSIVE", 128),
        ("BUS_OFF", 256),
        ("ERROR_ACTIVE", 0),
    ]


def test_a_replay_loses_nothing() -> None:
    from examples import replay

    found = replay.main()
    assert (len(found), sum(count for count, _ in found.values())) == (180, 12_974)


def test_a_master_hears_what_its_slaves_say() -> None:
    pytest.importorskip("ldfparser", reason="needs canwire[lin]")
    from examples import lin_master

    assert [state["LeftPosition"] for state in lin_master.main()] == [0.0, 40.0, 80.0]


def test_a_long_message_by_iso_tp() -> None:
    pytest.importorskip("isotp", reason="can-isotp is not installed")
    from examples import iso_tp

    flow_control = 1 + 71 // 8  # block size 8: one behind the first frame, then behind each full block
    assert iso_tp.main() == 1 + 71 + flow_control


def test_what_the_uds_server_answers() -> None:
    from examples import uds_server

    assert uds_server.main() == [
        "02 50 03",
        "06 62 f1 8c 43 34 32",
        "03 7f 22 31",
        "03 7f 85 11",
        "session 1",
    ]


def test_a_recording_is_read_back(tmp_path: Path) -> None:
    from examples import recording

    assert recording.main(tmp_path / "bus.log") == 99
