"""ISO-TP in virtual time: 500 bytes through 8-byte frames, with flow control: python examples/iso_tp.py

Needs canwire[can] and can-isotp.
"""

from __future__ import annotations

import can
import isotp

import canwire

NORMAL = isotp.AddressingMode.Normal_11bits


def pump(hub: canwire.Hub, sender: isotp.CanStack, receiver: isotp.CanStack) -> bytes:
    """Let both stacks and the bus work until a message is through."""
    while not receiver.available():
        sender.process()
        receiver.process()
        hub.run_for(0.0005)
    return bytes(receiver.recv())


def main() -> int:
    """How many frames the message took."""
    with canwire.connect(time="virtual") as hub:
        buses = [can.Bus(interface="canwire", channel="can0", bitrate=500_000, hub=hub) for _ in range(3)]
        tester = isotp.CanStack(buses[0], address=isotp.Address(NORMAL, txid=0x7E0, rxid=0x7E8))
        ecu = isotp.CanStack(
            buses[1], address=isotp.Address(NORMAL, txid=0x7E8, rxid=0x7E0), params={"stmin": 1}
        )
        sent = bytes(number & 0xFF for number in range(500))
        tester.send(sent)
        assert pump(hub, tester, ecu) == sent
        frames = 0
        while buses[2].recv(timeout=0) is not None:
            frames += 1
        print(f"500 bytes in {frames} frames and {hub.now_ns() / 1e6:.0f} ms of bus time")
        for bus in buses:
            bus.shutdown()
    return frames


if __name__ == "__main__":
    main()
