"""How many frames a second arrive from a serial adapter: our driver, in a hub, beside python-can's slcan.

    python benchmarks/slcan_driver.py [SECONDS]

The adapter is a process of its own that writes 8-byte frames to a pseudo terminal as quickly as they are read, and
answers commands. Ours are counted where a program in the hub's process takes them from its channel's queue.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pty
import select
import sys
import time
import tty
from collections.abc import Callable
from typing import Any

FRAME = b"t1238112233445566778%X\r"
CHUNK = b"".join(FRAME % (number & 15) for number in range(1000))
ANSWERS = {b"V": b"V1013\r", b"N": b"NA123\r", b"F": b"F00\r"}


def adapter(names: Any) -> None:
    """Frames as quickly as they are read, once O has come."""
    master, slave = pty.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    names.put(os.ttyname(slave))
    rest, out, at, is_open = b"", b"", 0, False
    while True:
        select.select([master], [master] if is_open or out else [], [])
        try:
            *lines, rest = (rest + os.read(master, 4096)).split(b"\r")
        except BlockingIOError:
            lines = []
        for line in lines:
            is_open = line == b"O" or (is_open and line != b"C")
            out, at = out[at:] + ANSWERS.get(line, b"\r"), 0
        if at == len(out) and is_open:
            out, at = CHUNK, 0
        with contextlib.suppress(BlockingIOError):
            at += os.write(master, memoryview(out)[at:])


def ours(port: str, seconds: float) -> tuple[int, int]:
    """Frames that a program took, and those that were lost because it did not take them in time."""
    import canwire
    from canwire import BitTiming, ChannelMode, LineMode
    from canwire.boards.config.configuration import Config

    with canwire.connect(time="real", config=Config()) as hub:
        board = hub.plug("slcan", port=f"{port}?stamps=0")
        control = hub.open_control(board.id, 0)
        channel = hub.open_channel(board.id, 0)
        channel.set_up(ChannelMode(1 << 16, 16, filter_size=0))
        channel.activate()
        control.initialise(LineMode(BitTiming.from_btr(0x00, 0x14)))
        control.start()
        count = counted_for(seconds, lambda: len(channel.receive_many(4096, 1.0)))
        return count, hub.line_status(board.id, 0).lost


def theirs(port: str, seconds: float) -> tuple[int, int]:
    import can

    with can.Bus(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1) as bus:
        return counted_for(seconds, lambda: bus.recv(1.0) is not None), 0


def counted_for(seconds: float, take: Callable[[], int]) -> int:
    take()
    count, end = 0, time.perf_counter() + seconds
    while time.perf_counter() < end:
        count += take()
    return count


def measured(who: Callable[[str, float], tuple[int, int]], seconds: float) -> tuple[float, int]:
    """frames/s, and frames lost."""
    names: Any = multiprocessing.Queue()
    process = multiprocessing.Process(target=adapter, args=(names,), daemon=True)
    process.start()
    count, lost = who(names.get(), seconds)
    process.kill()
    process.join()
    return count / seconds, lost


def rows(seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    (mine, lost), (beside, _) = measured(ours, seconds), measured(theirs, seconds)
    return [
        (
            "received from a serial dongle",
            f"{mine:,.0f} frames/s, {lost} lost = {mine / beside:.0f} x",
            f"its slcan {beside:,.0f} frames/s",
            "20 x",
        )
    ]


def main() -> None:
    print(rows(float(sys.argv[1]) if len(sys.argv) > 1 else 3.0))


if __name__ == "__main__":
    main()
