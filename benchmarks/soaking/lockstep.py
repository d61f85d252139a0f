"""Two programs in lockstep time and one that is killed beside them: `python lockstep.py FOLDER` prints what was heard.

Each run has a hub of its own. What one program hears of the other, and when, is the same in every run, whenever the
third one is killed: the line is a digest of it.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile

_SENDER = """
import canwire
with canwire.connect(timed=True, name="b sender") as hub:
    board = hub.boards()[0].id
    with hub.open_control(board, 0) as control:
        control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=80_000_000)))
        control.start()
        channel = hub.open_channel(board, 0)
    channel.set_up(canwire.ChannelMode(16, 16))
    channel.activate()
    hub.sleep(0.1)
    for number in range(100):
        channel.send(canwire.Frame(0x100, number.to_bytes(4, "little")))
        hub.sleep(0.001)
    hub.sleep(0.1)
"""
_HEARER = """
import canwire
with canwire.connect(timed=True, name="a hearer") as hub:
    board = hub.boards()[1].id
    with hub.open_control(board, 0) as control:
        control.initialise(canwire.LineMode(hub.boards()[1].lines[0].capabilities.timing(500_000)))
        control.start()
        channel = hub.open_channel(board, 0)
    channel.set_up(canwire.ChannelMode(256, 0))
    channel.activate()
    first = 0
    for _ in range(100):
        frame = channel.receive(60)
        first = first or frame.timestamp_ns
        print(frame.data.hex(), frame.timestamp_ns - first)
"""
_KILLED = """
import canwire
with canwire.connect(timed=True, name="c killed") as hub:
    print("at it", flush=True)
    while True:
        hub.sleep(0.0007)
"""
_PATIENCE_S = 120.0


def main() -> None:
    with tempfile.TemporaryDirectory(dir=sys.argv[1]) as folder:
        address = os.path.join(folder, "hub")
        words = ["serve", "--time", "lockstep", "--programs", "3", "--patience", "600", "--socket", address]
        with _started(["-m", "canwire", *words]) as hub:
            try:
                assert hub.stdout is not None
                assert "canwire hub on" in hub.stdout.readline()
                print(_heard(address), flush=True)
            finally:
                hub.kill()


def _heard(address: str) -> str:
    os.environ["CANWIRE_HUB"] = address
    with (
        _started(["-c", _KILLED]) as killed,
        _started(["-c", _HEARER]) as hearer,
        _started(["-c", _SENDER]) as sender,
    ):
        try:
            assert killed.stdout is not None
            assert killed.stdout.readline() == "at it\n"
            killed.kill()
            text, _ = hearer.communicate(timeout=_PATIENCE_S)
            assert sender.wait(_PATIENCE_S) == 0
        finally:
            for each in (killed, hearer, sender):
                each.kill()
    assert text.count("\n") == 100, text
    return hashlib.sha256(text.encode()).hexdigest()


def _started(words: list[str]) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE, text=True)


if __name__ == "__main__":
    main()
