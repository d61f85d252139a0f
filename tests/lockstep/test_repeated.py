"""Many programs that do random things: the same from the same seed, whatever else the machine does.

CANWIRE_LOCKSTEP_RUNS says how often (2), CANWIRE_LOCKSTEP_PROCESSES with how many processes (2).
"""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.hubs import LONG_S
from tests.lockstep.programs import bench

RUNS = int(os.environ.get("CANWIRE_LOCKSTEP_RUNS", "2"))
PROCESSES = int(os.environ.get("CANWIRE_LOCKSTEP_PROCESSES", "2"))
PROGRAM = """
import random, sys
import canwire

number, seed = int(sys.argv[1]), int(sys.argv[2])
dice = random.Random(1000 * seed + number)
with canwire.connect() as hub:
    places = canwire.find_lines(hub, "can0")
    place = places[number % len(places)]
    mode = canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000))
    canwire.bring_up(hub, place, lambda status: mode, lambda status: None, patience_s=10.0)
    with hub.open_channel(place.board.id, place.line) as channel:
        channel.set_up(canwire.ChannelMode(1000, 100, siblings=canwire.Siblings.EVERY))
        channel.activate()
        while hub.now_ns() < int(sys.argv[3]):
            what = dice.randrange(4)
            if what == 0:
                for _ in range(dice.randint(1, 5)):
                    frame = canwire.Frame(dice.randrange(0x800), dice.randbytes(dice.randint(0, 8)))
                    channel.send(frame, timeout=None)
            elif what == 1:
                hub.sleep(dice.choice([0, 0.0001, 0.001, 0.010]))
            else:
                frame = channel.receive(timeout=dice.choice([0.0005, 0.001, 0.020]))
                if frame is not None:
                    print(hub.now_ns(), frame.timestamp_ns, canwire.format_frame(frame))
"""


def played(home: Path, processes: int, seed: int) -> dict[str, str]:
    """What each program has printed."""
    with bench(home, "--programs", str(processes), "--patience", "60") as made:
        programs = {f"p{number}": PROGRAM for number in range(processes)}
        until_ns = 600_000_000 // processes
        words = {f"p{n}": (str(n), str(seed), str(until_ns)) for n in range(processes)}
        return made.run(programs, own_words=words, timeout_s=LONG_S * processes)


@pytest.mark.conforms("G-17", "N-35")
def test_the_same_every_time(tmp_path: Path) -> None:
    first = played(tmp_path / "1", PROCESSES, 1)
    assert min(text.count("\n") for text in first.values()) > 1
    for number in range(2, RUNS + 1):
        assert played(tmp_path / str(number), PROCESSES, 1) == first, f"run {number}"


@pytest.mark.conforms("G-17", "N-35")
def test_twenty_programs_do_the_same_on_a_loaded_machine(tmp_path: Path) -> None:
    first = played(tmp_path / "1", 20, 1)
    assert min(text.count("\n") for text in first.values()) > 1
    with ExitStack() as stack:
        for _ in range(os.cpu_count() or 1):
            busy = stack.enter_context(subprocess.Popen([sys.executable, "-c", "while True: pass"]))
            stack.callback(busy.kill)
        assert played(tmp_path / "2", 20, 1) == first
