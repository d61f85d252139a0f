"""Ixxat.Vci4 and Ixxat.Vci3, by programs in C# on a hub."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.hubs import LONG_S, Served, serving
from tests.native.dotnet.conftest import Mono

TWO_WITH_LIN = '[[bus]]\nname = "can0"\n[[bus]]\nname = "lin0"\ntype = "lin"\n' + "".join(
    f'[[board]]\nkind = "usb-to-can-fd"\nserial = "HW00000{number}"\nbuses = ["can0", "can0", "lin0"]\n'
    for number in (1, 2)
)


@pytest.mark.conforms("N-43")
def test_one_bus_with_a_program_in_python(mono: Mono, hub: Served) -> None:
    can = pytest.importorskip("can")
    with mono.start(mono.program("Classic.cs"), hub.address) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stdout.readline() == "started\n", process.communicate()
        with can.Bus(interface="canwire", channel="HW000002:0", bitrate=500_000, hub=hub.address) as other:
            process.stdin.write("go\n")
            process.stdin.flush()
            heard = other.recv(LONG_S)
            assert (heard.arbitration_id, bytes(heard.data)) == (0x123, b"\xca\xfe")
            other.send(can.Message(arbitration_id=0x18DAF110, data=range(1, 9)))
            answer = process.stdout.readline()
        assert answer == f": Data [{0x18DAF110}] Dlc=8 01 02 03 04 05 06 07 08\n"
        out, errors = process.communicate("\n", timeout=LONG_S)
        assert (process.returncode, out) == (0, "done\n"), errors


@pytest.mark.conforms("N-43")
@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("Fast.cs", "two rates, filters and a cyclic list"),
        ("Errors.cs", "every mistake has its exception"),
        ("Stream.cs", "all of them in order"),
        ("Threads.cs", "whatever the threads did"),
    ],
)
def test_vci4(mono: Mono, hub: Served, program: str, said: str) -> None:
    assert said in mono.run(mono.program(program), hub.address)


@pytest.mark.conforms("N-43")
def test_lin(mono: Mono, tmp_path: Path) -> None:
    with serving(tmp_path, TWO_WITH_LIN, time="real") as hub:
        assert "master, slave and monitor" in mono.run(mono.program("Lin.cs"), hub.address)


@pytest.mark.conforms("N-43")
def test_vci3s_manual(mono: Mono, hub: Served) -> None:
    program = mono.program("Version3.cs", "-define:VCI3")
    assert "V3's listings did what they say" in mono.run(program, hub.address)


@pytest.mark.conforms("N-45")
def test_who_waits_hears_of_the_hubs_end(mono: Mono, hub: Served) -> None:
    with mono.start(mono.program("Waits.cs"), hub.address) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        hub.process.kill()
        out, errors = process.communicate(timeout=LONG_S)
        assert (process.returncode, out) == (0, "heard of it\n"), out + errors
