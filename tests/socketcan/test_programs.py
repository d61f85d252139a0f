"""Programs that nothing can be preloaded into are named; and what `canwire run` itself is asked wrongly."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from canwire.socketcan.programs import trouble_with
from tests.hubs import LONG_S
from tests.missing import find_program
from tests.socketcan.bench import Bench, need


def built(folder: Path, name: str, *switches: str) -> str:
    find_program("gcc")
    (folder / "main.c").write_text("int main(void) { return 0; }\n")
    made = folder / name
    done = subprocess.run(["gcc", *switches, str(folder / "main.c"), "-o", str(made)], capture_output=True)
    if done.returncode:
        pytest.skip(f"gcc cannot link {switches}")
    return str(made)


def test_an_ordinary_program_and_a_script_are_fine(tmp_path: Path) -> None:
    script = tmp_path / "script"
    script.write_text("#!/bin/sh\n")
    assert trouble_with(built(tmp_path, "ordinary")) == ""
    assert trouble_with(str(script)) == ""
    assert trouble_with(str(tmp_path / "nothing")) == ""


def test_a_static_program(tmp_path: Path) -> None:
    assert "linked statically" in trouble_with(built(tmp_path, "static", "-static"))


def test_a_program_for_musl(tmp_path: Path) -> None:
    made = built(tmp_path, "musl", "-Wl,--dynamic-linker=/lib/ld-musl-x86_64.so.1")
    assert "musl" in trouble_with(made)


def test_a_program_for_another_machine(tmp_path: Path) -> None:
    made = Path(built(tmp_path, "other"))
    content = bytearray(made.read_bytes())
    content[4] = 1  # 32 bits
    made.write_bytes(content)
    assert "another machine" in trouble_with(str(made))


def test_a_set_uid_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = built(tmp_path, "mighty")
    os.chmod(made, 0o4755)
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert "set-uid" in trouble_with(made)


def test_what_cannot_be_served_is_said_once(bench: Bench, tmp_path: Path) -> None:
    made = built(tmp_path, "static", "-static")
    assert bench.start(made).communicate(timeout=30)[1] == ""
    spawn = f"os.waitpid(os.posix_spawn({made!r}, [{made!r}], os.environ), 0)"
    process = bench.start(sys.executable, "-c", f"import os; {spawn}; {spawn}")
    said = process.communicate(timeout=30)[1]
    assert said.count("starts a program that preloads nothing (posix_spawn): it has no CAN") == 1


def test_status_and_signals_are_the_program_s(bench: Bench) -> None:
    bench.run("sh", "-c", "exit 7", status=7)
    process = bench.start("cat")
    process.send_signal(signal.SIGUSR1)
    process.communicate(timeout=30)
    assert process.returncode == -signal.SIGUSR1


FINDS_SERVER = """
import os, select, signal, socket, struct
with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as asks:
    asks.connect(os.environ["CANWIRE_SOCKETCAN"] + "/control")
    server, = struct.unpack_from("i", asks.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
"""
ENDS_SERVER = f"""{FINDS_SERVER}
end = os.pidfd_open(server)
os.kill(server, signal.SIGTERM)
select.select([end], [], [])
"""


THREADS_OF_SERVER = f"""{FINDS_SERVER}
with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as can:
    can.bind(("can0",))
    can.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_RECV_OWN_MSGS, 1)
    can.send(struct.pack("=IB3x8s", 0x123, 0, bytes(8)))
    can.recv(16)  # by now the server has loaded numpy
    print(len(os.listdir("/proc/%d/task" % server)), os.environ.get("OPENBLAS_NUM_THREADS"))
"""


def test_its_server_has_none_of_numpys_threads(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """They kept another core busy for a tenth of a second at each start. The program's own numpy may have them."""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setenv("CANWIRE_HUB", bench.address)
    program = [sys.executable, "-c", THREADS_OF_SERVER]
    command = [sys.executable, "-m", "canwire", "run", "--", *program]  # a cold one, which has no numpy yet
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONG_S)
    assert (done.stdout, done.stderr) == ("2 None\n", "")  # what serves, and what hears the hub


def test_a_server_that_is_terminated_ends_without_a_word(bench: Bench) -> None:
    """It printed a traceback, as if something were wrong with it."""
    process = bench.start(sys.executable, "-c", ENDS_SERVER)
    assert process.communicate(timeout=LONG_S) == ("", "")


def test_what_a_program_leaves_behind_has_its_interfaces(bench: Bench) -> None:
    need("candump")
    script = "(sleep 0.5; exec candump -n 1 -T 20000 can0) > later.txt &"
    process = bench.start("sh", "-c", script, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    assert process.wait(LONG_S) == 0
    bench.until(lambda: bench.channels() == 1 and bench.servers_wait())
    bench.run("cansend", "can0", "123#11")
    bench.until(lambda: (bench.home / "later.txt").read_text() == "  can0  123   [1]  11\n")
    bench.until(lambda: bench.channels() == 0)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "no program to run"),
        (["--", "no-such-program"], "no-such-program: no such program"),
        (["--interface", "can0", "true"], "NAME=LINE"),
        (["--interface", "a-name-far-too-long=can0", "true"], "1 to 15 characters"),
        (["--interface", "vcan0=nothing", "true"], "no CAN line or bus 'nothing'"),
        (["--hub", "/nowhere/at/all", "true"], "/nowhere/at/all"),
    ],
)
def test_mistakes(bench: Bench, words: list[str], complaint: str) -> None:
    command = [sys.executable, "-m", "canwire", "run", *words]
    environment = {**os.environ, "CANWIRE_HUB": bench.address}
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 2
    assert complaint in done.stderr
