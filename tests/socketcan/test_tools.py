"""can-utils, unmodified; what each says is compared with the bus as `canwire dump` shows it."""

from __future__ import annotations

import re
import signal
import socket
import subprocess

import pytest

from tests.hubs import LONG_S, free_port
from tests.socketcan.bench import Bench, finished, frames, need


@pytest.mark.conforms("N-21", "PC-04")
def test_cansend(bench: Bench) -> None:
    texts = ["123#DEADBEEF", "123#R", "123#R5", "123##1AABBCCDD", "00000123#", "5AA#11.22.33"]
    dump = bench.dump("can0", "-l", "-n", str(len(texts)))
    bench.run("sh", "-c", "; ".join(f"cansend can0 {text}" for text in texts))
    assert frames(finished(dump)) == [text.replace(".", "") for text in texts]


@pytest.mark.conforms("N-21", "PC-05")
@pytest.mark.parametrize(
    "switches",
    [
        ["-e"],
        ["-f"],
        ["-b"],
        ["-R"],
        ["-m"],
        ["-I", "42A", "-L", "8", "-D", "i"],
        ["-L", "i"],
        ["-x"],
        ["-p", "10"],
        ["-c", "5"],
    ],
    ids=" ".join,
)
def test_cangen(bench: Bench, switches: list[str]) -> None:
    dump = bench.dump("can0", "-n", "40")
    said = bench.run("cangen", "can0", "-g", "0", "-n", "40", "-v", "-v", *switches)
    assert frames(said) == frames(finished(dump))


@pytest.mark.conforms("N-21", "PC-06", "PL-28")
def test_canplayer_plays_what_candump_logged(bench: Bench) -> None:
    log = "".join(f"(0.{k:06}) can0 {0x100 + k:03X}#{k:02X}\n" for k in range(50))
    (bench.home / "some.log").write_text(log)
    dump = bench.dump("can0", "-l", "-n", "100")
    bench.run(
        "canplayer", "-I", "some.log", "-l", "2", "-t", "vcan7=can0", options=("--interface", "vcan7=can0")
    )
    assert frames(finished(dump)) == frames(log) * 2


@pytest.mark.conforms("N-21", "PC-07")
def test_cansniffer_shows_what_is_on_the_bus(bench: Bench) -> None:
    need("cansniffer")
    sniffer = bench.listening("stdbuf", "-o0", "cansniffer", "can0", stdin=subprocess.PIPE)
    assert sniffer.stdin is not None
    bench.run("cansend", "can0", "123#4142")
    assert sniffer.stdout is not None
    seen = ""
    while "41 42" not in seen:
        seen += sniffer.stdout.read(1)
    sniffer.stdin.write("q\n")
    sniffer.stdin.flush()
    sniffer.communicate(timeout=LONG_S)
    assert "123" in seen


@pytest.mark.conforms("N-21", "PC-08")
def test_canbusload_counts_frames_and_their_bits(bench: Bench) -> None:
    need("canbusload")
    load = bench.listening("stdbuf", "-oL", "canbusload", "-e", "can0@500000")
    bench.run("cangen", "can0", "-g", "0", "-n", "300", "-I", "555", "-L", "8", "-D", "1122334455667788")
    # its pselect has a signal mask that nobody set: where that blocks the alarm it shows nothing until a frame comes
    bench.start("cangen", "can0", "-g", "100", "-I", "001", "-L", "0")
    assert load.stdout is not None
    counted = 0
    while counted < 300:
        line = load.stdout.readline()
        assert line, "canbusload has ended"
        if found := re.match(r"\s*can0@500000\s+(\d+)\s+(\d+)\s+(\d+)", line):
            with_data, rest = divmod(int(found[3]), 64)
            assert rest == 0
            assert with_data <= int(found[1])
            counted += with_data
    assert counted == 300
    load.send_signal(signal.SIGINT)


def test_cansequence_misses_nothing(bench: Bench) -> None:
    receiver = bench.listening("cansequence", "can0", "-r", "-v", "-q", "1")
    bench.run("cansequence", "can0", "--loop=1000")
    bench.run("cansend", "can0", "002#00")  # 1000 & 0xFF is due: out of sequence, which ends it
    output, errors = receiver.communicate(timeout=LONG_S)
    assert receiver.returncode == 1
    assert re.search(r"sequence CNT: +1000, RX: +0 +expected: 232", output + errors), (output, errors)


def test_canfdtest_in_full_duplex(bench: Bench) -> None:
    dut = bench.listening("canfdtest", "can0")
    said = bench.run("canfdtest", "-g", "-l", "500", "can0")
    assert "Test messages sent and received: 500" in said
    dut.send_signal(signal.SIGINT)


def test_canlogserver(bench: Bench) -> None:
    port = free_port()
    server = bench.start("canlogserver", "-p", str(port), "can0")
    with connected(bench, port, server) as client:
        bench.until(lambda: bench.channels() > 0 and bench.servers_wait())
        dump = bench.dump("can0", "-l", "-n", "1")
        bench.run("cansend", "can0", "123#DEADBEEF")
        client.settimeout(LONG_S)
        line = client.makefile().readline()
    assert frames(line) == frames(finished(dump)) == ["123#DEADBEEF"]
    server.terminate()


def connected(bench: Bench, port: int, server: subprocess.Popen[str]) -> socket.socket:
    made: list[socket.socket] = []

    def tried() -> bool:
        assert server.poll() is None, server.communicate()
        try:
            made.append(socket.create_connection(("127.0.0.1", port)))
        except ConnectionRefusedError:
            return False
        return True

    bench.until(tried)
    return made[0]


PDU = " ".join(f"{k & 0xFF:02X}" for k in range(300))


@pytest.mark.conforms("PP-01", "N-26")
@pytest.mark.parametrize(
    ("send", "receive"),
    [
        ([], []),
        (["-p", "AA"], ["-p", "AA", "-P", "a"]),
        ([], ["-b", "4", "-m", "1"]),
        (["-x", "33"], ["-x", "33"]),
        (["-x", "33:44"], ["-x", "44:33"]),
        (["-L", "72:64:1"], ["-L", "72:64:1"]),
        (["-t", "1000000"], ["-f", "1000"]),
    ],
    ids=str,
)
def test_isotpsend_and_isotprecv(bench: Bench, send: list[str], receive: list[str]) -> None:
    receiver = bench.listening("isotprecv", "-s", "321", "-d", "123", *receive, "can0")
    bench.run("isotpsend", "-s", "123", "-d", "321", *send, "can0", stdin=PDU)
    assert finished(receiver).split() == PDU.split()


@pytest.mark.conforms("PP-01", "N-26")
def test_isotpperf_watches_a_transfer(bench: Bench) -> None:
    perf = bench.listening("isotpperf", "-s", "123", "-d", "321", "can0")
    receiver = bench.listening("isotprecv", "-s", "321", "-d", "123", "can0")
    bench.run("isotpsend", "-s", "123", "-d", "321", "can0", stdin=PDU)
    finished(receiver)
    assert perf.stdout is not None
    seen = ""
    while "100%" not in seen:
        seen += perf.stdout.read(1)
    perf.terminate()


@pytest.mark.conforms("PL-12")
def test_a_shell_under_run_has_both_ends(bench: Bench) -> None:
    script = "candump -n 1 -T 20000 can0 & sleep 0.3; cansend can0 123#11; wait"
    assert bench.run("sh", "-c", script) == "  can0  123   [1]  11\n"
