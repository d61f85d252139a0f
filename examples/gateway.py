"""Two ECUs on two buses, and a gateway that passes some frames on: python examples/gateway.py"""

from __future__ import annotations

from canwire import Frame, Lab, LabNode, NodeScript

PASSED_ON = {0x100: 0x500}  # identifier on the powertrain bus -> identifier on the body bus


class Engine(NodeScript):
    """Reports its speed every 10 ms."""

    def on_start(self) -> None:
        self.rpm = 800
        self.every(0.010)

    def on_timer(self) -> None:
        self.rpm += 50
        self.send(Frame(0x100, self.rpm.to_bytes(2, "big")))
        self.send(Frame(0x101, b"\x00"))  # of no interest to others


class Gateway(NodeScript):
    """Listens on one bus and sends on another."""

    def __init__(self, onto: LabNode) -> None:
        self.onto = onto

    def on_message(self, frame: Frame) -> None:
        if frame.id in PASSED_ON:
            self.onto.send(Frame(PASSED_ON[frame.id], frame.data))


def main() -> list[Frame]:
    """What the dashboard has heard after 50 ms."""
    with Lab() as lab:
        powertrain = lab.can_bus("powertrain", bit_rate=500_000)
        body = lab.can_bus("body", bit_rate=125_000)
        dashboard = body.node("dashboard")
        powertrain.node("gateway", Gateway(body.node("gateway")))
        powertrain.node("engine", Engine())
        lab.run_for(0.055)
        heard = dashboard.receive_many(100)
    for frame in heard:
        print(f"{frame.timestamp_ns / 1e6:8.3f} ms  {frame.id:03X}  {int.from_bytes(frame.data, 'big')} rpm")
    return heard


if __name__ == "__main__":
    main()
