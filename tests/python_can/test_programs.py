"""Unmodified python-can programs in processes of their own, found by the entry point."""

from __future__ import annotations

import subprocess
import time
from contextlib import suppress

import pytest

from tests.python_can.programs import Program

LONG = 30


def ended(process: subprocess.Popen[str]) -> str:
    said, _ = process.communicate("", LONG)
    assert process.returncode == 0
    return said


@pytest.mark.conforms("PL-01")
def test_request_and_answer(program: Program) -> None:
    answering = program(
        """
import can
with can.Bus(interface="canwire", channel="can0", bitrate=250000) as bus:
    print("ready", flush=True)
    for message in bus:
        message.arbitration_id += 8
        bus.send(message)
        if message.data[0] == 9:
            break
""",
        cold=True,
    )
    asking = program(
        """
import can
with can.Bus(interface="canwire", channel="can0", bitrate=250000) as bus:
    for k in range(10):
        bus.send(can.Message(arbitration_id=0x7E0, data=[k], is_extended_id=False))
        print(bus.recv(10))
""",
        ready=False,
        cold=True,
    )
    lines = ended(asking).splitlines()
    assert [line.split("ID:")[1].split()[0] for line in lines] == ["7e8"] * 10
    ended(answering)


LISTENER = """
import can, sys, threading
bus = can.ThreadSafeBus(interface="canwire", channel="can0", receive_own_messages=True)
done = threading.Event()
def listener(message):
    print(message.arbitration_id, message.is_rx, flush=True)
    if message.arbitration_id == 0x7FF:
        done.set()
bus.set_filters([{{"can_id": {id}, "can_mask": 0x7FF, "extended": False}},
                 {{"can_id": 0x7FF, "can_mask": 0x7FF, "extended": False}}])
notifier = can.Notifier(bus, [listener, can.BufferedReader()])
print("ready", flush=True)
done.wait()
notifier.stop()
assert bus.state is can.BusState.ACTIVE
bus.shutdown()
"""


@pytest.mark.conforms("PL-01", "PL-13")
def test_several_programs_with_filters_of_their_own(program: Program) -> None:
    listeners = [program(LISTENER.format(id=id)) for id in range(1, 6)]  # more than there are lines
    sending = program(
        """
import can, time
with can.Bus(interface="canwire", channel="can0") as bus:
    for id in range(1, 6):
        bus.send(can.Message(arbitration_id=id, is_extended_id=False))
    task = bus.send_periodic(can.Message(arbitration_id=0x7FE, is_extended_id=False), 0.001, duration=0.05)
    time.sleep(0.2)
    bus.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
""",
        ready=False,
    )
    ended(sending)
    assert [ended(one) for one in listeners] == [f"{id} True\n2047 True\n" for id in range(1, 6)]


@pytest.mark.conforms("PL-01", "PL-13")
def test_a_program_that_asks_for_another_rate_is_told_who_is_there(program: Program) -> None:
    first = program("""
import can, sys
with can.Bus(interface="canwire", channel="can0", bitrate=125000) as bus:
    print("ready", flush=True)
    sys.stdin.read()
""")
    second = program(
        """
import can
try:
    can.Bus(interface="canwire", channel="HW000001:0", bitrate=500000)
except can.CanInitializationError as error:
    print(error)
print([config["channel"] for config in can.detect_available_configs("canwire")])
""",
        ready=False,
    )
    told, there = ended(second).splitlines()
    assert "125000 bit/s" in told
    assert "python-can: -c" in told
    assert (
        there
        == "['can0', 'HW000001:0', 'HW000001:1', 'HW000002:0', 'HW000002:1', 'HW000003:0', 'HW000004:0']"
    )
    ended(first)


AT_SAMPLE_POINT = """
import can, sys
timing = can.BitTimingFd.from_sample_point(80_000_000, 500_000, {sample}, 4_000_000, 80)
with can.Bus(interface="canwire", channel="can0", timing=timing) as bus:
    print("ready", flush=True)
"""
RECEIVES = """    came = 0
    while sys.stdin.readline() == "look\\n":
        while bus.recv(0):
            came += 1
        print(came, flush=True)
"""
SENDS = """    for k in range(10):
        bus.send(can.Message(arbitration_id=k, data=bytes(12), is_extended_id=False, is_fd=True, bitrate_switch=True))
    while bus.state is can.BusState.ACTIVE and sys.stdin.readline() == "look\\n":
        print(bus.state.name, flush=True)
    print("LEFT", flush=True)
"""


def asked(process: subprocess.Popen[str]) -> str:
    assert process.stdin is not None
    assert process.stdout is not None
    with suppress(BrokenPipeError):
        process.stdin.write("look\n")
        process.stdin.flush()
    return process.stdout.readline().strip()


@pytest.mark.finding("wire-2 1")
@pytest.mark.parametrize(("sample", "came"), [(87.5, "10"), (75, "0")])
def test_fd_programs_with_other_sample_points_fail_as_on_copper(
    program: Program, sample: float, came: str
) -> None:
    """500k/4M: both at 87.5 % talk; at 87.5 and 75 % no frame gets through, and the sender is active no more."""
    receiver = program(AT_SAMPLE_POINT.format(sample=87.5) + RECEIVES)
    sender = program(AT_SAMPLE_POINT.format(sample=sample) + SENDS)
    until = time.monotonic() + LONG
    while asked(receiver) != came or (came == "0" and asked(sender) != "LEFT"):
        assert time.monotonic() < until
    assert asked(receiver) == came
