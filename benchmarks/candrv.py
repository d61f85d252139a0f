"""CANDRV: events that one handle hands out as text and as structures, and a bus that its send channels fill."""

from __future__ import annotations

import os
import statistics
import tempfile
import threading
import time
from pathlib import Path

import shared

import canwire
from canwire import candrv
from canwire.candrv import win32
from canwire.candrv.constants import GENERIC_READ, IOCTL_CAN_READ_EVENT_DATA
from canwire.candrv.structures import CAN_EVENT

QUEUE = 32_768
BATCH = 500
BOARD = "picocom1"
RATE = 1_000_000
BITS = 111  # of a frame with eight bytes, stuff bits apart
CHANNELS = 3


def reading(count: int) -> tuple[float, float]:
    """Events in a second by ReadFile and by IOCTL_CAN_READ_EVENT_DATA, from a queue that was filled before."""
    with tempfile.TemporaryDirectory() as folder, canwire.connect(time="virtual") as hub:
        registry = Path(folder, "canwire.toml")
        registry.write_text(f'[candrv.CID1]\nBoard = "{BOARD}"\nEventQueueSize = {QUEUE}\n')
        os.environ["CANWIRE_CONFIG"] = str(registry)
        win32.use(hub)
        try:
            return _reading(hub, count)
        finally:
            win32.use(None)
            del os.environ["CANWIRE_CONFIG"]


def _reading(hub: canwire.Hub, count: int) -> tuple[float, float]:
    control, channel = _peer(hub)
    handle = win32.CreateFile("CID1:", GENERIC_READ, 0)
    win32.PROGRAM.handle(handle).accept_all()
    text, event, read = bytearray(100), bytearray(CAN_EVENT.SIZE), [0]
    ways = (
        lambda: win32.ReadFile(handle, text, 100, read),
        lambda: win32.DeviceIoControl(
            handle, IOCTL_CAN_READ_EVENT_DATA, None, 0, event, CAN_EVENT.SIZE, read
        ),
    )
    rates = []
    for way in ways:
        for _ in range(count // BATCH):
            for number in range(BATCH):
                channel.send(canwire.Frame(0x100 + number % 16, b"12345678"))
            hub.run_for(BATCH * 2 * BITS / RATE)
        began = time.perf_counter()
        for _ in range(count):
            assert way()
        rates.append(count / (time.perf_counter() - began))
    win32.CloseHandle(handle)
    channel.close()
    control.close()
    return rates[0], rates[1]


def filling(seconds: float) -> tuple[float, int]:
    """The bus's load in % under three send channels, in real time with a hub of its own, and messages that got lost."""
    with shared.served("real") as process, canwire.connect(process.address) as hub:
        control, channel = _peer(hub)
        handles = [candrv.open(hub=hub, read=False) for _ in range(CHANNELS)]
        over, sent = threading.Event(), [0] * CHANNELS

        def send(place: int) -> None:
            while not over.is_set():
                handles[place].write_message(0x100 + place, b"12345678")
                sent[place] += 1

        threads = [threading.Thread(target=send, args=(place,)) for place in range(CHANNELS)]
        for thread in threads:
            thread.start()
        received, end = 0, time.monotonic() + seconds
        load = 0.0
        while time.monotonic() < end:
            received += len(channel.receive_many(4096, 0.05))
            load = max(load, hub.line_status(channel.board, channel.line).load)
        over.set()
        for thread in threads:
            thread.join()
        for handle in handles:
            handle.close()
        while frames := channel.receive_many(4096, 0.2):
            received += len(frames)
        channel.close()
        control.close()
        return load, sum(sent) - received


def _peer(hub: canwire.Hub) -> tuple[canwire.Control, canwire.HubChannel]:
    board = hub.board("usb-to-can-fd").id
    control = hub.open_control(board, 0)
    control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(RATE)))
    control.start()
    channel = hub.open_channel(board, 0)
    channel.set_up(canwire.ChannelMode(1 << 15, 1 << 10, filter_size=0))
    channel.activate()
    return control, channel


def rows(scale: int, seconds: float) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    runs = [reading(30_000 // scale) for _ in range(3)]
    text, binary = (statistics.median(figures) for figures in zip(*runs, strict=True))
    load, lost = filling(seconds)
    return [
        ("CANDRV, ReadFile through one handle", f"{text:,.0f} events/s", "", "100,000"),
        ("  IOCTL_CAN_READ_EVENT_DATA", f"{binary:,.0f} events/s", "", "200,000"),
        (
            f"  {CHANNELS} send channels at 1 Mbit/s, real time",
            f"{load:.0f} % load, {lost} lost",
            "",
            "100 %, 0",
        ),
    ]
