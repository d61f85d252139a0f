"""Campaigns for the tests: files of their own, as workers read them."""

from __future__ import annotations

from pathlib import Path

FLIPS = '''
"""Flips of a bit, and noise."""
from canwire import Draw, Frame, campaign


@campaign(bit_rate=[250_000, 500_000], bit=range(20, 26), noise=Draw.log_uniform(1e-6, 1e-2))
def flips(lab, bit_rate, bit, noise):
    bus = lab.can_bus(bit_rate=bit_rate)
    a, b = bus.node("a"), bus.node("b")
    bus.faults.noise(noise)
    for number in range(20):
        a.send(Frame(0x100 + number, bytes([bit])))
    lab.run_until_idle()
    assert bus.error_frames < 3, f"{bus.error_frames} errors"
    return {"errors": bus.error_frames, "seconds": lab.now_ns / 1e9}
'''

ENDS = '''
"""Run 5 takes its process down, run 7 raises."""
import os
from canwire import campaign


@campaign(number=range(12))
def ends(lab, number):
    if number == 5:
        os._exit(9)
    if number == 7:
        raise KeyError("seven")
    return {"square": number * number}
'''

LASTS = '''
"""Run 2 never ends, and run 4 cannot even be told to."""
from canwire import campaign


def for_ever():
    while True:
        pass


@campaign(number=range(6))
def lasts(lab, number):
    if number == 2:
        for_ever()
    while number == 4:
        try:
            for_ever()
        except BaseException:
            pass
    return {"square": number * number}
'''

WILD = '''
"""Each run is another way to end more than itself; each leaves its number in FOLDER."""
import asyncio, fcntl, os, signal, sys
from pathlib import Path
import pytest
from canwire import campaign

FOLDER = Path(__file__).parent


class Mute(Exception):
    def __str__(self):
        raise RuntimeError("no words")


def leave(): sys.exit("enough")
def interrupt(): raise KeyboardInterrupt
def cancel(): raise asyncio.CancelledError
def generate(): raise GeneratorExit
def fail(): pytest.fail("not so")
def mute(): raise Mute
def signalled(): signal.raise_signal(signal.SIGINT)
def fault(): os.kill(os.getpid(), signal.SIGSEGV)
def closes(): os.closerange(3, 4096)
def forks(): os.fork()
def silences(): sys.stdout = sys.stderr = None
def prints(): print("here is the run"); os.write(2, b"and here\\n")
def nothing(): pass
def orphans():
    if not (FOLDER / "once").exists():
        (FOLDER / "once").touch()
        held = open(FOLDER / "held", "w")
        fcntl.flock(held, fcntl.LOCK_EX)  # until this process ends
        os.kill(os.getppid(), signal.SIGKILL)
        signal.pause()


@campaign(what=WAYS)
def wild(lab, what):
    with open(FOLDER / "played", "a") as file:
        file.write(what + "\\n")
    globals()[what]()
    return {"value": 1}
'''


def written(folder: Path, name: str, text: str) -> Path:
    """The file."""
    path = folder / name
    path.write_text(text)
    return path
