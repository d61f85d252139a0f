"""python-can's own `interface="socketcan"`, in a process that knows nothing of canwire."""

from __future__ import annotations

import subprocess
import sys

import pytest

import canwire
from tests.hubs import LONG_S
from tests.socketcan.bench import Bench, finished, frames

pytest.importorskip("can")
pytestmark = pytest.mark.usefixtures("python_can_without_mf4")

FRAMES_BOTH_WAYS = """
import can
with can.Bus(interface="socketcan", channel="can0", fd=True) as bus, \\
     can.Bus(interface="socketcan", channel="can0", fd=True, receive_own_messages=True) as own:
    for message in (
        can.Message(arbitration_id=0x123, data=b"abc", is_extended_id=False),
        can.Message(arbitration_id=0x12345678, is_remote_frame=True, dlc=3),
        can.Message(arbitration_id=0x124, data=bytes(64), is_fd=True, bitrate_switch=True, is_extended_id=False),
    ):
        own.send(message, timeout=5)
        seen, back = bus.recv(20), own.recv(20)
        assert seen.equals(message, timestamp_delta=None, check_channel=False, check_direction=False), seen
        assert back.equals(message, timestamp_delta=None, check_channel=False, check_direction=False), back
        assert not back.is_rx and seen.timestamp == back.timestamp > 0
"""

FILTERS = """
import can
filters = [{"can_id": 0x200, "can_mask": 0x700, "extended": False}]
with can.Bus(interface="socketcan", channel="can0", can_filters=filters) as bus, \\
     can.Bus(interface="socketcan", channel="can0") as sender:
    for id in (0x1FF, 0x200, 0x2FF, 0x300, 0x2AA):
        sender.send(can.Message(arbitration_id=id, is_extended_id=False))
    assert [bus.recv(20).arbitration_id for _ in range(3)] == [0x200, 0x2FF, 0x2AA]
    assert bus.recv(0) is None
"""

PERIODIC = """
import can, time
with can.Bus(interface="socketcan", channel="can0") as bus, can.Bus(interface="socketcan", channel="can0") as heard:
    message = can.Message(arbitration_id=0x123, data=[1], is_extended_id=False)
    task = bus.send_periodic(message, 0.01)
    first = heard.recv(20)
    task.modify_data(can.Message(arbitration_id=0x123, data=[2], is_extended_id=False))
    while heard.recv(20).data[0] != 2:
        pass
    task.stop()
    while heard.recv(0.2) is not None:
        pass
    bus.send_periodic(message, 0.01, duration=0.05)
    count = 0
    while heard.recv(20 if count < 4 else 0.3) is not None:
        count += 1
    assert 4 <= count <= 6, count
"""

NOTIFIER = """
import asyncio, can
async def main():
    with can.Bus(interface="socketcan", channel="can0") as bus, can.Bus(interface="socketcan", channel="can0") as other:
        reader = can.AsyncBufferedReader()
        notifier = can.Notifier(bus, [reader], loop=asyncio.get_running_loop())
        for number in range(100):
            other.send(can.Message(arbitration_id=number, is_extended_id=False))
        seen = [(await asyncio.wait_for(reader.get_message(), 20)).arbitration_id for _ in range(100)]
        notifier.stop()
        assert seen == list(range(100))
asyncio.run(main())
"""


@pytest.mark.conforms("PL-12", "N-28")
@pytest.mark.parametrize(
    "program",
    [FRAMES_BOTH_WAYS, FILTERS, PERIODIC, NOTIFIER],
    ids=["frames", "filters", "periodic", "notifier"],
)
def test_python_can(bench: Bench, program: str) -> None:
    bench.run(sys.executable, "-c", program)


REPEATING = """
import can
bus = can.Bus(interface="socketcan", channel="can0")
task = bus.send_periodic(can.Message(arbitration_id=0x123, data=[1], is_extended_id=False), 0.01)
input()
"""


ISOTP = """
import socket
one = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_ISOTP)
one.bind(("can0", 0x123, 0x321))
assert one.getsockname() == ("can0", 0x123, 0x321), one.getsockname()
other = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_ISOTP)
other.bind(("can0", 0x321, 0x123))
other.setblocking(True)
for size in (1, 7, 8, 100, 4096, 66_000):
    other.send(bytes(k & 255 for k in range(size)))
    assert one.recv(1 << 17) == bytes(k & 255 for k in range(size))
for data in (b"", bytes(66_001)):
    try:
        one.send(data)
    except OSError as error:
        assert error.errno == 22
    else:
        raise AssertionError("sent")
"""


@pytest.mark.conforms("PP-01", "N-26")
def test_isotp_sockets_of_python_itself(bench: Bench) -> None:
    bench.run(sys.executable, "-c", ISOTP)


@pytest.mark.conforms("N-24")
def test_the_hub_repeats_its_messages(bench: Bench) -> None:
    dump = bench.dump("can0", "-l", "-n", "3")
    program = bench.start(sys.executable, "-c", REPEATING, stdin=subprocess.PIPE)
    assert frames(finished(dump)) == ["123#01"] * 3
    holders = {place.status(bench.hub).scheduler_holder for place in canwire.every_line(bench.hub, "CAN")}
    assert any(holder.startswith("canwire run") for holder in holders), holders
    program.communicate("\n", timeout=LONG_S)
    bench.until(lambda: bench.channels() == 0)


@pytest.mark.conforms("PL-12", "N-28")
def test_what_it_sends_is_on_the_bus(bench: Bench) -> None:
    dump = bench.dump("can0", "-l", "-n", "1")
    program = """
import can
with can.Bus(interface="socketcan", channel="can0") as bus:
    bus.send(can.Message(arbitration_id=0x123, data=b"1"))
"""
    bench.run(sys.executable, "-c", program)
    assert frames(finished(dump)) == ["00000123#31"]
