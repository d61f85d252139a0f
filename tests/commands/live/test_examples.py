"""The examples in the help of the live tools do what they say they do, on a bus at work."""

from __future__ import annotations

import importlib
import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

import canwire
from canwire import Frame
from canwire.commands import VERBS, main
from tests.commands.conftest import running_lines

CAR = Path(__file__).parents[1] / "car.dbc"
LASTING = ("dump", "gen", "load", "view")  # they end after --seconds, if not before


def examples() -> list[str]:
    """Of each verb, without what stands behind two blanks and where output goes."""
    found = []
    for verb in (*LASTING, "detect", "doctor"):
        text = importlib.import_module(VERBS[verb].module).__doc__ or ""
        found += re.findall(rf"^canwire ({verb}\b.*?)(?: > \S+)?(?:  .*)?$", text, re.MULTILINE)
    return found


@pytest.fixture
def busy_hub(hub_address: str) -> Iterator[str]:
    """Two CAN FD lines of a board of their own; one sends every 5 ms, the other acknowledges."""
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        hub.plug("usb-to-can-fd", "HW000009", temporary=True)
        _, (place, _) = running_lines(hub, closing, "HW000009:0", "HW000009:1")
        scheduler = closing.enter_context(hub.open_scheduler(place.board.id, place.line))
        ticks = place.info.capabilities.cyclic
        scheduler.resume()
        record = canwire.frames_to_array([Frame(0x123, b"\x11\x22")]).tobytes()
        scheduler.start(scheduler.add(record, max(1, round(0.005 * ticks.clock_hz / ticks.divisor))))
        yield hub_address


def test_there_are_some() -> None:
    assert len(examples()) >= 30


@pytest.mark.parametrize("example", examples())
def test_the_help_s_examples(
    busy_hub: str,
    example: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if "--db" in example:
        pytest.importorskip("cantools")
    monkeypatch.chdir(tmp_path)
    shutil.copy(CAR, tmp_path)
    words = shlex.split(example)
    if words[0] in LASTING:
        words += ["--seconds", "0.1"]
    status = main([*words, "--hub", busy_hub])
    told = capsys.readouterr()
    assert (status, "Traceback" in told.err) == (0, False), told.err
    if words[0] == "detect":
        assert "500000" in told.out
    if words == ["dump", "can0", "--seconds", "0.1"]:
        assert "  can0  123   [2]  11 22\n" in told.out
