"""`canwire isotp` and `canwire uds`, against ECUs of a lab that shares its bus, and against each other."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire.commands import main
from tests import warm
from tests.hubs import LONG_S

pytest.importorskip("isotp")
pytest.importorskip("udsoncan")
pytestmark = [pytest.mark.realtime, pytest.mark.conforms("PC-14")]
PATIENT = ("--timeout", str(LONG_S))


@pytest.fixture
def lab(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[canwire.Lab]:
    monkeypatch.setenv("CANWIRE_HUB", str(tmp_path / "hub.sock"))
    monkeypatch.chdir(tmp_path)
    with canwire.Lab(time="real") as found:
        yield found


@pytest.fixture
def ecu(lab: canwire.Lab) -> canwire.ecus.UdsEcu:
    found = canwire.ecus.UdsEcu(
        identifiers={0xF190: b"CANWIRE0123456789", 0x0101: b"\x01"}, writable=(0x0101,)
    )
    lab.can_bus("can0", bit_rate=500_000).node("ecu", found)
    lab.serve(os.environ["CANWIRE_HUB"])
    return found


def done(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> tuple[list[str], str]:
    capsys.readouterr()
    assert main(list(words)) == status, capsys.readouterr().err
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return captured.out.splitlines(), captured.err


@pytest.mark.smoke
def test_services_by_name(capsys: pytest.CaptureFixture[str], ecu: canwire.ecus.UdsEcu) -> None:
    told, _ = done(
        capsys, "uds", "can0", "ReadDataByIdentifier:F190", "present", "session:extended", "unlock:1",
        "write:0101:6F6B", "read:101", "raw:22F190", "reset:soft", "--key", "xor:FF", *PATIENT,
    )  # fmt: skip
    vin = b"CANWIRE0123456789".hex(" ").upper()
    assert told == [
        f'F190: {vin}  "CANWIRE0123456789"', "present", "session 3", "unlocked, level 1", "0101: written",
        '0101: 6F 6B  "ok"', f"62 F1 90 {vin}", "reset",
    ]  # fmt: skip
    assert (ecu.identifiers[0x0101], ecu.resets) == (b"ok", 1)


def test_what_the_ecu_refuses_has_its_name(
    capsys: pytest.CaptureFixture[str], ecu: canwire.ecus.UdsEcu
) -> None:
    told, why = done(capsys, "uds", "can0", "read:0101", "write:0101:00", "read:0101", *PATIENT, status=1)
    assert told == ["0101: 01"]
    assert why.endswith("canwire: write:0101:00: ServiceNotSupportedInActiveSession (NRC 7F)\n")
    _, why = done(capsys, "uds", "can0", "session:3", "unlock:1", "--key", "xor:00", *PATIENT, status=1)
    assert "unlock:1: InvalidKey (NRC 35)" in why
    _, why = done(capsys, "uds", "can0", "present", "--tx", "7E1", "--timeout", "0.1", status=1)
    assert "present: no answer from 7E8 in 0.1 s" in why


def test_an_ecu_with_extended_addressing(capsys: pytest.CaptureFixture[str], lab: canwire.Lab) -> None:
    """Another one with the same identifiers does not answer."""
    bus = lab.can_bus("can0", bit_rate=500_000)
    for address in (0x12, 0x13):
        ecu = canwire.ecus.UdsEcu(identifiers={0xF190: bytes([address])}, extended=(address, 0xF1))
        bus.node(f"ecu{address}", ecu)
    lab.serve(os.environ["CANWIRE_HUB"])
    told, _ = done(capsys, "uds", "can0", "read:F190", "-x", "12:F1", *PATIENT)
    assert told == ["F190: 12"]


def test_a_file_is_flashed_with_a_key_of_the_user_s_own(
    capsys: pytest.CaptureFixture[str], ecu: canwire.ecus.UdsEcu, tmp_path: Path
) -> None:
    image = bytes(range(256)) * 4 + b"end"
    (tmp_path / "image.bin").write_bytes(image)
    (tmp_path / "keys.py").write_text(
        "def key(level, seed):\n    return bytes(255 - each for each in seed)\n"
    )
    words = ["session:programming", "unlock:1", "flash:image.bin:08000010", "--key", "keys.py:key", *PATIENT]
    told, progress = done(capsys, "uds", "can0", *words)
    assert told[-1] == f"{len(image)} bytes to 08000010"
    assert "512 of 1027 bytes, 49 %\n" in progress
    assert "1027 of 1027 bytes, 100 %\n" in progress
    assert bytes(ecu.memory[16 : 16 + len(image)]) == image


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["reed:F190"], "did you mean read?"),
        (["write:F190"], "it is write:ID:HEX"),
        (["read:what"], "'what' is no number in hex"),
        (["session:fast"], "default, programming, extended"),
        (["unlock:1"], "--key says how a seed becomes a key"),
        (["unlock:1", "--key", "magic"], "invert, xor:HEX, or FILE.py:FUNCTION"),
        (["unlock:1", "--key", "none.py:key"], "there is no file none.py"),
        (["present", "--tx", "7E8"], "the same as --rx"),
        (["present", "--tx", "18DA10F1"], "both of 11 bits, or both of 29"),
        (["present", "--pad", "100"], "a byte in hex"),
        (["present", "--stmin", "128"], "0 to 127 ms"),
        (["present", "--extended", "123"], "one or two bytes in hex, F1 or F1:12"),
        (["flash:none.bin:0"], "No such file"),
    ],
)
def test_mistakes(
    capsys: pytest.CaptureFixture[str], ecu: canwire.ecus.UdsEcu, words: list[str], why: str
) -> None:
    _, told = done(capsys, "uds", "can0", *words, status=2)
    assert why in told


@pytest.mark.parametrize(
    "options", [[], ["--fd"], ["-x", "12:F1"], ["--tx", "18DA10F1", "--rx", "18DAF110", "--pad", "CC"]]
)
def test_messages_from_one_program_to_another(
    capsys: pytest.CaptureFixture[str], lab: canwire.Lab, options: list[str]
) -> None:
    """A third one only listens, and sees frames and messages of both directions."""
    bus = lab.can_bus("can0", bit_rate=500_000, data_bit_rate=2_000_000)
    lab.serve(os.environ["CANWIRE_HUB"])
    bus.node("acknowledges")
    messages = ["22F190", bytes(range(100)).hex().upper()]
    other = {"--tx": "--rx", "--rx": "--tx", "12:F1": "F1:12"}
    mirrored = [other.get(word, word) for word in options]
    if "--tx" not in options:
        mirrored += ["--tx", "7E8", "--rx", "7E0"]
    verbs = [sys.executable, "-m", "canwire", "isotp"]
    with (
        warm.Popen([*verbs, "dump", "can0", *options, "-n", "2"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                   text=True) as dump,
        warm.Popen([*verbs, "recv", "can0", *mirrored, *PATIENT, "-n", "2"], stdout=subprocess.PIPE,
                   stderr=subprocess.PIPE, text=True) as receiver,
    ):  # fmt: skip
        assert "listening to" in _until(dump, "listening to")
        assert "receiving" in _until(receiver, "receiving")
        done(capsys, "isotp", "send", "can0", *messages, *options, *PATIENT)
        received, _ = receiver.communicate(timeout=LONG_S)
        shown, _ = dump.communicate(timeout=LONG_S)
    assert received.split() == messages
    lines = [line.split("  ", 1)[1] for line in shown.splitlines()]
    assert [line for line in lines if " bytes" in line] == ["3 bytes  22F190", f"100 bytes  {messages[1]}"]
    assert lines[0] == "[SF] 3  22 F1 90"
    assert any(line.startswith("[FF] 100") for line in lines)
    assert any(line.startswith("[FC] continue to send, block size 0") for line in lines)
    assert sum(line.startswith("[CF]") for line in lines) == (
        1 if "--fd" in options else 16 if "-x" in options else 14
    )


def _until(process: subprocess.Popen[str], text: str) -> str:
    assert process.stderr is not None
    for line in process.stderr:
        if text in line:
            return line
    raise AssertionError(f"ended with {process.wait()} before it said {text!r}")


def test_nobody_takes_a_message(capsys: pytest.CaptureFixture[str], lab: canwire.Lab) -> None:
    lab.can_bus("can0", bit_rate=500_000).node("acknowledges")
    lab.serve(os.environ["CANWIRE_HUB"])
    _, why = done(capsys, "isotp", "send", "can0", "00" * 20, "--timeout", "0.05", status=1)
    assert "FlowControl timed out" in why
    _, why = done(capsys, "isotp", "send", "can0", "3E00", "--answer", "--timeout", "0.05", status=1)
    assert "no answer from 7E8 in 0.05 s" in why
    _, why = done(capsys, "isotp", "send", "can0", "what", status=2)
    assert "a message in hex" in why
