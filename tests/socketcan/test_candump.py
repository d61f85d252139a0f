"""candump, unmodified, beside `canwire dump`: the same bus."""

from __future__ import annotations

import re

import pytest

import canwire
from tests.socketcan.bench import Bench, finished, frames

SENT = ["123#DEADBEEF", "123#", "00000123#11", "123#R", "123#R5", "1FFFFFFF#0102030405060708", "7FF#00"]
SENT_FD = ["123##1AABB", "456##0" + "11" * 12, "00ABCDEF##3" + "22" * 64]


def send(bench: Bench, *texts: str) -> None:
    bench.run("sh", "-c", "; ".join(f"cansend can0 {text}" for text in texts))


@pytest.mark.smoke
@pytest.mark.conforms("PC-01", "PL-12", "N-21")
def test_its_lines_are_those_of_canwire_dump(bench: Bench) -> None:
    wanted = SENT + SENT_FD
    ours = bench.dump("can0", "-n", str(len(wanted)))
    theirs = bench.listening("candump", "-n", str(len(wanted)), "can0")
    send(bench, *wanted)
    # once it has seen a long identifier, candump indents the short ones behind it
    assert [line.split() for line in finished(theirs).splitlines()] == [
        line.split() for line in finished(ours).splitlines()
    ]


@pytest.mark.conforms("PC-02")
def test_logs_of_any_interface_have_frames_and_times_of_canwire_dump(bench: Bench) -> None:
    count = len(SENT)
    ours = bench.dump("can0", "-l", "-n", str(count))
    theirs = bench.listening("candump", "-l", "-n", str(count), "any")
    printed = bench.listening("candump", "-L", "-n", str(count), "can0")
    send(bench, *SENT)
    finished(theirs)
    (log,) = bench.home.glob("candump-*.log")
    expected = finished(ours)
    assert frames(log.read_text()) == frames(expected)
    shown = finished(printed)
    assert [line.split()[0] for line in shown.splitlines()] == [
        line.split()[0] for line in expected.splitlines()
    ]


@pytest.mark.conforms("PC-02")
@pytest.mark.parametrize(
    ("switches", "shape"),
    [
        (["-ta"], r" \(\d+\.\d{6}\)  can0  123   \[2\]  41 42"),
        (["-tA"], r" \(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d\.\d{6}\)  can0  123   \[2\]  41 42"),
        (["-tz"], r" \(000\.000000\)  can0  123   \[2\]  41 42"),
        (["-td"], r" \(000\.000000\)  can0  123   \[2\]  41 42"),
        (["-ta", "-H"], r" \(\d+\.\d{6}\)  can0  123   \[2\]  41 42"),
        (["-x"], r"  can0  RX - -  123   \[2\]  41 42"),
        (["-a"], r"  can0  123   \[2\]  41 42\s+'AB'"),
        (["-S"], r"  can0  123   \[2\]  42`41"),
        (["-i"], r"  can0  123   \[2\]  01000001 01000010"),
        (["-c"], r".*can0.*123.*\[2\]  41 42.*"),
        (["-s", "0", "-r", "100000", "-d", "-D", "-e"], r"  can0  123   \[2\]  41 42"),
    ],
)
def test_switches(bench: Bench, switches: list[str], shape: str) -> None:
    dump = bench.listening("candump", *switches, "-n", "1", "-T", "20000", "can0")
    send(bench, "123#4142")
    (line,) = finished(dump).splitlines()
    assert re.fullmatch(shape, line), line


@pytest.mark.conforms("PC-02")
def test_silence_ends_it(bench: Bench) -> None:
    assert bench.run("candump", "-T", "50", "can0") == ""


@pytest.mark.conforms("PC-03")
@pytest.mark.parametrize(
    ("filters", "passing"),
    [
        ("123:7FF", ["123#01", "123#R", "00000123#02"]),
        ("123:C00007FF", ["123#01"]),
        ("00000123:DFFFFFFF", ["00000123#02"]),
        ("123~7FF", ["124#03", "00000124#04"]),
        ("123:7FF,124:7FF", ["123#01", "123#R", "00000123#02", "124#03", "00000124#04"]),
        ("120:7F0,123~7FF,j", ["124#03", "00000124#04"]),
        ("0~0", []),
    ],
)
def test_filters(bench: Bench, filters: str, passing: list[str]) -> None:
    dump = bench.listening("candump", "-L", f"can0,{filters}", "can0,7AA:7FF")
    send(bench, "123#01", "123#R", "00000123#02", "124#03", "00000124#04", "7AA#")
    assert dump.stdout is not None
    seen: list[str] = []
    for _ in range(2):  # candump looks at its sockets in turn: one mark may overtake what waits in the other
        marks = seen.count("7AA#")
        while seen.count("7AA#") == marks or len(seen) - seen.count("7AA#") < len(passing):
            seen.append(dump.stdout.readline().split()[2])
        send(bench, "7AA#")
    assert [text for text in seen if text != "7AA#"] == passing


@pytest.mark.conforms("PC-02", "PC-03", "N-22")
def test_error_frames_of_a_shorted_bus(bench: Bench) -> None:
    dump = bench.listening("candump", "-e", "-n", "3", "-T", "20000", "can0,0~0,#FFFFFFFF")
    ours = bench.dump("can0", "-e", "-n", "1")
    bench.hub.short("can0")
    sender = bench.start("cangen", "can0", "-g", "10")
    output = finished(dump)
    assert "ERRORFRAME" in output
    assert re.search(r"protocol-violation|controller-problem", output), output
    assert "ERRORFRAME" in finished(ours)
    bench.hub.short("can0", False)
    sender.terminate()


@pytest.mark.conforms("N-23")
def test_a_pulled_board_ends_it_as_a_pulled_adapter_does(bench: Bench) -> None:
    dump = bench.listening("candump", "HW000002_0")
    bench.hub.unplug("HW000002")
    output, errors = dump.communicate(timeout=30)
    assert dump.returncode == 1
    assert "No such device" in errors or "Network is down" in errors, (output, errors)


@pytest.mark.conforms("N-23")
def test_a_stopped_line_is_a_network_that_is_down(bench: Bench) -> None:
    dump = bench.listening("candump", "HW000001_0")
    (place,) = canwire.find_lines(bench.hub, "HW000001:0")
    with bench.hub.open_control(place.board.id, place.line) as control:
        control.stop()
        _, errors = dump.communicate(timeout=30)
    assert "Network is down" in errors
    bench.run("cansend", "HW000001_0", "123#")  # whoever comes next starts it again


@pytest.mark.conforms("N-22")
def test_all_interfaces_are_those_that_come_later_as_well(bench: Bench) -> None:
    dump = bench.listening("candump", "-n", "2", "any")
    bench.hub.plug("usb-to-can-fd", "HW000077", buses=("can0", "can0"))
    bench.run("cansend", "can0", "123#01")
    bench.run("cansend", "HW000077_0", "123#02")
    assert frames(finished(dump)) == ["123 [1] 01", "123 [1] 02"]
