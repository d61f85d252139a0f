"""The emulated dongle: its parser, rubbish by the megabyte, and 1 Mbit/s saturated in both directions over a pseudo
terminal, without loss when the client reads.

    python benchmarks/slcan.py [--short]
"""

from __future__ import annotations

import contextlib
import os
import random
import select
import subprocess
import sys
import tempfile
import time
import tty
from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

import canwire
from canwire.slcan import DIALECTS, Dongle, Settings

WINDOW = 6  # commands without a reply: the dongle's queue is never full, so none is refused for long
BIT_RATE_COMMAND = b"S8\r"
PATIENCE_S = 20.0


def parsed(count: int, chunk: int) -> float:
    """Frames a second out of a stream that comes in such pieces."""
    text = b"".join(
        canwire.format_slcan_frame(canwire.Frame(k & 0x7FF, k.to_bytes(8, "little"))) for k in range(count)
    )
    reader = canwire.SlcanReader()
    began = time.perf_counter()
    found = sum(len(reader.feed(text[at : at + chunk])) for at in range(0, len(text), chunk))
    spent = time.perf_counter() - began
    assert found == count
    return count / spent


def formatted(count: int) -> float:
    """Frames a second, with time stamps."""
    frame = canwire.Frame(0x123, bytes(8))
    write = canwire.format_slcan_frame
    began = time.perf_counter()
    for _ in range(count):
        write(frame, 0x4D67)
    return count / (time.perf_counter() - began)


class Nothing:
    """A CAN side that swallows everything."""

    def open(self, setup: object) -> None: ...
    def close(self) -> None: ...
    def count_refused(self, count: int) -> None: ...
    def send(self, frame: canwire.Frame, *, single_shot: bool = False) -> None: ...
    def poll(self) -> list[canwire.Frame]:
        return []

    def events(self) -> list[canwire.BusEvent]:
        return []

    def lost(self) -> int:
        return 0


_GOOD = (
    b"S4 O C t10021133 T0000010021133 r1002 F M00006000 m00001FF0 V N Z1 L s031C  b1009".replace(b" ", b"\r")
    + b"5A" * 12
    + b"\rY5\rD000001001AA\r"
)


def rubbish(count: int, seed: int = 1) -> tuple[float, int]:
    """Bytes a second of random and mutated ones through whole dongles; the largest output any of them held."""
    chosen = random.Random(seed)
    good = _GOOD * 20
    dongles = [Dongle(Nothing(), lambda: 0, Settings(dialect=one)) for one in DIALECTS.values()]
    largest = done = 0
    spent = 0.0
    while done < count:
        block = bytearray(chosen.randbytes(4096))
        if done // 4096 % 2:
            block = bytearray(good)
            for _ in range(chosen.randrange(1, 200)):
                block[chosen.randrange(len(block))] = chosen.randrange(256)
        began = time.perf_counter()
        for dongle in dongles:
            dongle.feed(block)
            largest = max(largest, len(dongle.output))
        spent += time.perf_counter() - began
        done += len(block)
    for dongle in dongles:
        dongle.feed(b"\r")
        dongle.unplug_host()
    dongles[0].feed(b"V\r")
    assert bytes(dongles[0].output) == b"V1013\r"
    return count * len(dongles) / spent, largest


class Traffic(NamedTuple):
    """What crossed a saturated bus."""

    seconds: float
    to_host: int
    from_host: int
    lost: int

    @property
    def rate(self) -> float:
        return (self.to_host + self.from_host) / self.seconds


@contextlib.contextmanager
def dongle_on_pty(address: str, folder: str) -> Iterator[str]:
    """`canwire slcan` in a process of its own; its link."""
    link = f"{folder}/tty"
    command = [sys.executable, "-m", "canwire", "slcan", "--pty", link, "--hub", address]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, env={**os.environ, "XDG_STATE_HOME": folder}
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield link
        finally:
            process.terminate()


class Host:
    """A program on the pseudo terminal that reads what comes, and waits for replies."""

    def __init__(self, link: str, count: int) -> None:
        self._port = os.open(link, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._port)
        os.set_blocking(self._port, False)
        self._reader = canwire.SlcanReader()
        self._left = deque(range(count))
        self._asked: deque[int] = deque()
        self.received: list[int] = []
        self.refused = 0

    def begin(self) -> None:
        os.write(self._port, b"\r\r" + BIT_RATE_COMMAND + b"O\r")
        while self._reply_count() < 4:
            pass

    def _reply_count(self) -> int:
        select.select([self._port], [], [], PATIENCE_S)
        self._replies = getattr(self, "_replies", 0) + os.read(self._port, 4096).count(b"\r")
        return self._replies

    def step(self) -> bool:
        """Send and read what there is; False if nothing came for long."""
        new = b""
        while self._left and len(self._asked) < WINDOW:
            k = self._left.popleft()
            self._asked.append(k)
            new += b"t1008%016X\r" % k
        if new:
            os.write(self._port, new)
        if not select.select([self._port], [], [], PATIENCE_S)[0]:
            return False
        # a BELL stands without a CR
        for item in self._reader.feed(os.read(self._port, 65_536).replace(b"\a", b"\a\r")):
            if isinstance(item, canwire.Frame):
                self.received.append(int.from_bytes(item.data, "big"))
            elif item in (b"z", b"\a"):
                k = self._asked.popleft()
                if item == b"\a":
                    self.refused += 1
                    self._left.append(k)
        return True

    @property
    def idle(self) -> bool:
        return not self._left and not self._asked

    def close(self) -> None:
        os.close(self._port)


def saturated(to_host: int, from_host: int) -> Traffic:
    """So many 8-byte frames each way at 1 Mbit/s as quickly as the bus takes them."""
    from shared import served

    with contextlib.ExitStack() as closing:
        folder = closing.enter_context(tempfile.TemporaryDirectory())
        address = closing.enter_context(served("real")).address
        hub = closing.enter_context(canwire.connect(address))
        link = closing.enter_context(dongle_on_pty(address, folder))
        board = hub.board("usb-to-can-fd").id
        control = hub.open_control(board, 0)
        control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(1_000_000)))
        control.start()
        channel = hub.open_channel(board, 0)
        channel.set_up(canwire.ChannelMode(1 << 17, 1 << 17))
        channel.activate()
        host = Host(link, from_host)
        host.begin()
        if to_host:
            frames = [canwire.Frame(0x200, k.to_bytes(8, "big")) for k in range(to_host)]
            channel.send_array(canwire.frames_to_array(frames))
        began = time.perf_counter()
        there: list[canwire.Frame] = []
        while len(host.received) < to_host or len(there) < from_host:
            if not host.idle or len(host.received) < to_host:
                if not host.step():
                    break
                there += channel.receive_many(4096)
            elif not (more := channel.receive_many(4096, PATIENCE_S)):
                break
            else:
                there += more
        spent = time.perf_counter() - began
        host.close()
    lost = to_host - len(set(host.received)) + from_host - len({frame.data for frame in there})
    assert host.received == sorted(host.received)
    return Traffic(spent, len(host.received), len(there), lost)


def rows(scale: int) -> list[tuple[str, str, str, str]]:
    """For benchmarks/run.py's table."""
    frames = 20_000 // scale
    quick = parsed(200_000 // scale, 4096)
    found = [
        ("slcan: frames parsed, pieces of 4096 bytes", f"{quick:,.0f} frames/s", "", "500,000"),
        ("  of 64 bytes", f"{parsed(200_000 // scale, 64):,.0f} frames/s", "", "500,000"),
        ("  formatted, with time stamps", f"{formatted(200_000 // scale):,.0f} frames/s", "", "500,000"),
    ]
    rate, largest = rubbish(10_000_000 // scale)
    found.append(
        (
            f"  random and mutated bytes, {10 // scale or 1} million",
            f"{rate / 1e6:.1f} MB/s, {largest} held",
            "",
            "",
        )
    )
    for what, to_host, from_host in (
        ("from the bus to the host", frames, 0),
        ("from the host to the bus", 0, frames),
        ("both", frames, frames),
    ):
        one = saturated(to_host, from_host)
        found.append(
            (
                f"  1 Mbit/s over a pseudo terminal, {what}",
                f"{one.rate:,.0f} frames/s, {one.lost} lost",
                "",
                "0 lost",
            )
        )
    return found


if __name__ == "__main__":
    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    for row in rows(10 if "--short" in sys.argv else 1):
        print("  ".join(cell.ljust(width) for cell, width in zip(row, (56, 36, 0, 8), strict=True)))
