"""What docs/faults.md shows of shared boards runs as it stands there, and so do the tutorial's lines about them."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

import canwire
from tests.docs.blocks import blocks, run_tests
from tests.hubs import connected, embedded

DOCS = Path(__file__).resolve().parents[2] / "docs"
RUN = re.compile(
    r"^<!-- run: (\S+) -->\n```python\n(.*?)^```\n\n```text\n(.*?)^```", re.MULTILINE | re.DOTALL
)
FILE = re.compile(r"^<!-- file: (\S+) -->\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
CALL = re.compile(r"^\| `(\w+)\(", re.MULTILINE)
CONFIG = '[[bus]]\nname = "can0"\n[[board]]\nkind = "usb-to-can"\nserial = "HW000001"\n'


def page() -> str:
    return (DOCS / "faults.md").read_text(encoding="utf-8")


def samples() -> dict[str, tuple[str, str]]:
    found = {name: (code, shown) for name, code, shown in RUN.findall(page())}
    assert set(found) == {"hub", "lab"}
    return found


def printed(code: str) -> str:
    output = io.StringIO()
    with contextlib.redirect_stdout(output):
        exec(compile(code, "<faults.md>", "exec"), {"__name__": "sample"})
    return output.getvalue()


def played(block: str, frames: int = 1) -> tuple[canwire.LabNode, canwire.LabNode, list[canwire.Frame]]:
    """Sender, receiver, and what arrived, on a bus at 500 kbit/s that this block of the page was run on."""
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        a, b = bus.node("a"), bus.node("b")
        exec(compile(block, "<faults.md>", "exec"), {"bus": bus, "a": a, "b": b})
        for _ in range(frames):
            a.send(canwire.Frame(0x123, b"\x55"))
        lab.run_until_idle()
        return a, b, [frame for _ in range(frames) if (frame := b.receive()) is not None]


def test_the_examples_do_what_is_said_above_them() -> None:
    text = page()
    twice, overload, alone, spike = [block.text for block in blocks(DOCS / "faults.md") if not block.mark][:4]
    assert "its TEC is\n16, and 15 after the frame has been sent" in text
    assert played(twice)[0].tec == 15
    assert "the next frame begins 18 bits after this one instead of 3" in text
    undisturbed, disturbed = played("", 2)[2], played(overload, 2)[2]
    bits = [(two.timestamp_ns - one.timestamp_ns) / 2_000 for one, two in (undisturbed, disturbed)]
    assert bits[1] - bits[0] == 18 - 3
    a, _, arrived = played(alone)
    assert ([frame.id for frame in arrived], a.tec > 0) == ([0x123], True)
    assert len(played(spike)[2]) == 1


def test_the_sample_on_a_hub_prints_what_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    code, shown = samples()["hub"]
    with embedded(CONFIG, time="fast") as engine, contextlib.ExitStack() as closing:
        monkeypatch.setattr(canwire, "connect", lambda: closing.enter_context(connected(engine)))
        assert printed(code) == shown


def test_the_sample_of_a_lab_prints_what_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("can")
    monkeypatch.chdir(tmp_path)
    code, shown = samples()["lab"]
    assert printed(code) == shown


def test_the_tests_pass(tmp_path: Path) -> None:
    files = dict(FILE.findall(page()))
    assert set(files) == {"test_reader.py", "test_bus_off.py"}
    for name, code in files.items():
        (tmp_path / name).write_text(code)
    assert "2 passed" in run_tests(tmp_path)


def test_every_call_of_the_tables_exists() -> None:
    calls = set(CALL.findall(page()))
    assert calls >= {
        "flip",
        "inject",
        "noise",
        "hold",
        "disconnect",
        "drift",
        "wrong_rate",
        "cable",
        "babble",
    }
    assert {name for name in calls if not hasattr(canwire.CanBusFaults, name)} == set()
