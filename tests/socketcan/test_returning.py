"""The interfaces of `canwire run` go down with their hub, and are up again with it, under the programs' sockets."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import canwire
from tests.hubs import serving
from tests.socketcan.bench import Bench, Process, finished

pytestmark = pytest.mark.conforms("N-59")
PROGRAM = """
import errno, fcntl, socket, struct, sys
def opened(interface, type=socket.SOCK_RAW, protocol=socket.CAN_RAW, *ids):
    made = socket.socket(socket.AF_CAN, type, protocol)
    made.settimeout(60)
    made.bind((interface, *ids))
    return made
def frame(id):
    return struct.pack("=IB3x8s", id, 8, bytes(8))
def told(call, *given):
    try:
        return call(*given)
    except OSError as error:
        return errno.errorcode.get(error.errno, str(error))
def received(wire, *wanted):
    while True:
        got = told(wire.recv, 16)
        if isinstance(got, str):
            return got
        id, = struct.unpack_from("=I", got)
        if id in wanted:
            return f"{id:03X}"
def flags():
    return struct.unpack_from("16sH", fcntl.ioctl(bound, 0x8913, struct.pack("16s16x", b"can0")))[1] & 0x41
manager = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_BCM)
manager.connect(("can0",))
def cyclic(id, interval_us):
    TX_SETUP, SETTIMER_STARTTIMER = 1, 3
    head = struct.pack("@3I4l2I0q", TX_SETUP, SETTIMER_STARTTIMER, 0, 0, 0, 0, interval_us, id, 1)
    manager.send(head + frame(id))
transfers = opened("can0", socket.SOCK_DGRAM, socket.CAN_ISOTP, 0x701, 0x702)
bound, everything = opened("can0"), opened("")
cyclic(0x111, 10_000)
cyclic(0x112, 10_003)
print("ready", flags(), flush=True)
sys.stdin.readline()
print(received(bound), told(transfers.recv, 8), flags(), told(bound.send, frame(0x100)), flush=True)
later = opened("can0")
print(received(later), flush=True)
sys.stdin.readline()
print(received(bound, 0x222), received(later, 0x222), received(everything, 0x222), flags(), flush=True)
bound.send(frame(0x333))
transfers.send(b"again")
sys.stdin.readline()
"""


def tell(program: Process) -> str:
    """The next line of the program, which goes on for it."""
    assert program.stdin is not None
    assert program.stdout is not None
    program.stdin.write("\n")
    program.stdin.flush()
    return program.stdout.readline()


def channels(hub: canwire.Hub) -> dict[str, int]:
    """The number of channels on each line of can0."""
    lines = canwire.lines_now(hub, canwire.find_lines(hub, "can0"))
    return {place.address: status.channels for place, status in lines}


def test_sockets_receive_again_with_a_hub_that_was_killed(real_bench: Bench, tmp_path: Path) -> None:
    program = real_bench.start(sys.executable, "-c", PROGRAM, stdin=-1)
    assert program.stdout is not None
    assert program.stderr is not None
    assert program.stdout.readline() == "ready 65\n"
    before = channels(real_bench.hub)
    real_bench.kill_hub()
    assert tell(program) == "ENETDOWN ENETDOWN 0 ENETDOWN\n"
    assert program.stdout.readline() == "ENETDOWN\n"
    with serving(tmp_path, time="real") as served, canwire.connect(served.address) as hub:
        while "the hub is back" not in (line := program.stderr.readline()):
            assert line
        assert channels(hub) == before
        lines = canwire.lines_now(hub, canwire.find_lines(hub, "can0"))
        other = next(place for place, status in lines if status.running and not status.channels)
        with hub.open_channel(other.board.id, other.line) as channel:
            channel.set_up(canwire.ChannelMode(4096, 64))
            channel.activate()
            channel.send(canwire.Frame(0x222))
            assert tell(program) == "222 222 222 65\n"
            heard: set[int] = set()
            while not heard >= {0x111, 0x112, 0x333, 0x702}:
                heard |= {found.id for found in channel.receive_many(64, timeout=30)}
            assert 0x100 not in heard
        finished(program)


@pytest.mark.parametrize("words", [("-D", "can0"), ("any",)])
def test_candump_waits_as_on_a_kernel(words: tuple[str, ...], real_bench: Bench, tmp_path: Path) -> None:
    """With -D, or on all interfaces, of which the kernel tells it nothing."""
    dump = real_bench.listening("candump", *words)
    assert dump.stdout is not None
    assert dump.stderr is not None
    real_bench.run("cansend", "can0", "122#")
    assert "122   [0]" in dump.stdout.readline()
    real_bench.kill_hub()
    with serving(tmp_path, time="real"):
        while "the hub is back" not in (line := dump.stderr.readline()):
            assert line
        real_bench.run("cansend", "can0", "123#11")
        assert "123   [1]  11" in dump.stdout.readline()
    assert dump.poll() is None
