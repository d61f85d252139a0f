"""Four nodes start at the same moment; the bus decides: python examples/arbitration.py"""

from __future__ import annotations

from canwire import Frame, Lab

WAITING = {"brake": 0x050, "engine": 0x100, "door": 0x3A0, "radio": 0x6F0}


def main() -> list[str]:
    """Who got through, in this order."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        nodes = {name: bus.node(name) for name in WAITING}
        logger = bus.node("logger")
        for name, id in reversed(WAITING.items()):
            nodes[name].send(Frame(id, bytes(8)))
        lab.run_until_idle()

        names = {id: name for name, id in WAITING.items()}
        order = []
        for frame in logger.receive_many(10):
            name = names[frame.id]
            order.append(name)
            losses = nodes[name].arbitration_losses
            print(
                f"{frame.timestamp_ns / 1000:7.1f} us  {frame.id:03X}  {name:7} lost arbitration {losses} times"
            )
    return order


if __name__ == "__main__":
    main()
