"""Frames that come back to the program that sent them, whatever happens to its line meanwhile."""

from __future__ import annotations

import sys

import canwire
from tests.socketcan.bench import Bench, finished

SENDER = """
import errno, socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("HW000001_0",))
for number in range(3):
    wire.send(struct.pack("=IB3x8s", 0x100 + number, 0, b""))
print("sent", flush=True)
while True:
    try:
        id, = struct.unpack_from("=I", wire.recv(16))
    except OSError as error:
        print(errno.errorcode[error.errno], flush=True)
        continue
    print(f"{id:03X}", flush=True)
    if id == 0x7FF:
        break
"""


def test_what_waited_while_the_line_was_stopped_is_still_its_senders(bench: Bench) -> None:
    """Its sender did not ask for its own frames; in the soak it was given those of a line that had been stopped."""
    program = bench.start(sys.executable, "-c", SENDER, stdout=-1)
    assert program.stdout is not None
    assert program.stdout.readline() == "sent\n"
    hub = bench.hub
    sender, other = hub.board("HW000001").id, hub.board("HW000002").id
    bench.until(lambda: hub.line_status(sender, 0).transmitting)
    with hub.open_control(sender, 0) as control:
        control.stop()
        assert program.stdout.readline() == "ENETDOWN\n"
        control.start()
    channel = hub.open_channel(other, 0)
    channel.set_up(canwire.ChannelMode(64, 64))
    channel.activate()
    with hub.open_control(other, 0) as control:
        control.initialise(canwire.LineMode(hub.boards()[1].lines[0].capabilities.timing(500_000)))
        control.start()
        heard = [channel.receive(30) for _ in range(3)]
        assert [frame.id for frame in heard if frame is not None] == [0x100, 0x101, 0x102]
        channel.send(canwire.Frame(0x7FF))
        assert finished(program).split() == ["7FF"]
