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


def written(folder: Path, name: str, text: str) -> Path:
    """The file."""
    path = folder / name
    path.write_text(text)
    return path
