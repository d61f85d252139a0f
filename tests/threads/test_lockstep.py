"""Threads of programs in processes of their own, on a hub in lockstep: as in a hub of their own process."""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path

import pytest

import canwire

can = pytest.importorskip("can")

from tests.threads.shapes import REQUESTS, play  # noqa: E402  (python-can is an extra)

pytestmark = [pytest.mark.finding("machines 4"), pytest.mark.timeout(120)]
SHAPES_FILE = Path(__file__).with_name("shapes.py")
Lockstep = Callable[..., dict[str, str]]
START = f"import can, runpy\nshapes = runpy.run_path({str(SHAPES_FILE)!r})\n"
OPEN = 'can.Bus("can0", interface="canwire", bitrate=500_000)'


def test_one_program_with_threads_gives_the_log_that_it_gives_alone(canwire_lockstep: Lockstep) -> None:
    program = f"{START}print(*shapes['play']('notified', lambda: {OPEN}), sep='\\n')\n"
    heard = canwire_lockstep({"program": program})["program"]
    with canwire.connect(time="virtual") as hub, canwire.in_time(hub):
        alone = play("notified", functools.partial(can.Bus, "can0", interface="canwire", hub=hub))
    assert heard.splitlines() == alone


def test_three_programs_with_threads(canwire_lockstep: Lockstep) -> None:
    def ecu(shape: str, number: int) -> str:
        return f"{START}with {OPEN} as bus:\n    shapes[{shape!r}](bus, {number})\n"

    programs = {
        "first": ecu("notified", 1),
        "second": ecu("cyclic", 2),
        "tester": f"{START}with {OPEN} as bus:\n    print(*shapes['tester'](bus), sep='\\n')\n",
    }
    heard = [line.split()[1] for line in canwire_lockstep(programs)["tester"].splitlines()]
    for number in range(REQUESTS):
        assert f"{0x220 + number:X}" in heard
        assert f"{0x330 + number:X}" in heard
    assert heard.count("302") > 20
    assert heard.count("312") > 14
