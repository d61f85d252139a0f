"""A request and its answer between two programs at 1 Mbit/s in real time: 8 bytes each way, 0.26 ms on the wire.

    python benchmarks/round_trip.py [TIMES]

Both programs under one `canwire run`, then each under its own. Prints how long a round trip took (the shortest is what
the path takes by itself, the others have whatever else the machine does) and how much processor time.
"""

from __future__ import annotations

import subprocess
import sys

from socketcan import Usage, hub, run, wait_for_listener

TIMES = 2000
ANSWERS = """
import socket, struct
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("can0",))
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, struct.pack("<II", 0x100, 0x7FF))
while wire.recv(16)[8:9] != b"E":
    wire.send(struct.pack("<IB3x8s", 0x101, 8, b"answered"))
"""
ASKS = """
import socket, struct, sys, time
wire = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
wire.bind(("can0",))
wire.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, struct.pack("<II", 0x101, 0x7FF))
took = []
for _ in range(int(sys.argv[1])):
    begun = time.perf_counter()
    wire.send(struct.pack("<IB3x8s", 0x100, 8, b"question"))
    wire.recv(16)
    took.append(time.perf_counter() - begun)
wire.send(struct.pack("<IB3x8s", 0x100, 8, b"End"))
took.sort()
shown = [f"{took[len(took) * part // 100] * 1e3:.3f} ({part} %)" for part in (0, 10, 25, 50, 90)]
print("    ms:", ", ".join(shown))
"""


def measure(address: str, times: int, usage: Usage, *, together: bool) -> None:
    print("under one `canwire run`:" if together else "under two:", flush=True)
    asks, answers = [sys.executable, "-c", ASKS, str(times)], [sys.executable, "-c", ANSWERS]
    if together:
        both = '"$1" -c "$2" & sleep 1; "$1" -c "$3" "$4"; wait'
        words = ["sh", "-c", both, "sh", sys.executable, ANSWERS, ASKS, str(times)]
        usage.begin()
        run(address, *words).wait()
    else:
        other: subprocess.Popen[str] = run(address, *answers)
        wait_for_listener(address)
        usage.begin()
        run(address, *asks).wait()
        other.wait()
    spent = sum(usage.seconds().values())
    print(
        f"    {spent / times * 1e3:.3f} ms of processor time for one, all processes together and their start"
    )


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else TIMES
    with hub("real") as at, Usage(at) as used:
        measure(at, count, used, together=True)
        measure(at, count, used, together=False)
