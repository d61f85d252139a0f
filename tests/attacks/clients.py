"""Programs that attack a hub, each in a process of its own, and honest ones beside them that keep an account."""

from __future__ import annotations

import contextlib
import subprocess
import sys
from collections.abc import Iterator

import canwire
from tests.hubs import LONG_S

TIMING = canwire.BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)

# what every hostile program begins with: a hub, its first board, and an active channel on its second line
BEGIN = """
import os, sys, threading, canwire
hub = canwire.connect(sys.argv[1], name="hostile")
board = hub.boards()[0].id
channel = hub.open_channel(board, 1)
channel.set_up(canwire.ChannelMode(64, 64))
channel.activate()
"""
END = """
print("done", flush=True)
sys.stdin.read()
"""


@contextlib.contextmanager
def hostile(address: str, script: str) -> Iterator[subprocess.Popen[str]]:
    """A program that has done its worst, and stays; killed in the end."""
    command = [sys.executable, "-c", BEGIN + script + END, address]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            assert process.stdout.readline() == "done\n"
            yield process
        finally:
            process.kill()


class Honest:
    """Sends from one line to another of the first board, and counts."""

    def __init__(self, address: str) -> None:
        self.hub = canwire.connect(address, name="honest")
        self.board = self.hub.boards()[0].id
        self.sending = self._line(0, canwire.ChannelMode(1, 64, frames=False))
        self.receiving = self._line(1, canwire.ChannelMode(4096, 0))

    def exchange(self, count: int) -> None:
        """Send so many frames, one after the other; each of them comes, and nothing of it is lost."""
        for number in range(count):
            self.sending.send(canwire.Frame(0x123, number.to_bytes(4, "little")), timeout=LONG_S)
            while True:
                frame = self.receiving.receive(LONG_S)
                assert frame is not None, f"frame {number} never came"
                if frame.id == 0x123:
                    break
            assert int.from_bytes(frame.data, "little") == number
        assert self.receiving.status().lost == 0

    def close(self) -> None:
        self.hub.close()

    def _line(self, line: int, mode: canwire.ChannelMode) -> canwire.HubChannel:
        control = self.hub.open_control(self.board, line)
        control.initialise(canwire.LineMode(TIMING))
        control.start()
        channel = self.hub.open_channel(self.board, line)
        channel.set_up(mode)
        channel.activate()
        return channel
