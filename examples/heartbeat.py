"""A supervisor that notices when a device falls silent: python examples/heartbeat.py"""

from __future__ import annotations

from canwire import Frame, Lab, NodeScript

HEARTBEAT, ALARM = 0x701, 0x081
PERIOD_S, PATIENCE_S = 0.100, 0.250


class Device(NodeScript):
    """Says every 100 ms that it is alive."""

    def on_start(self) -> None:
        self.every(PERIOD_S, lambda: self.send(Frame(HEARTBEAT, b"\x05")))


class Supervisor(NodeScript):
    """Sends an alarm when the device has been silent for 250 ms."""

    def on_start(self) -> None:
        self.watch = self.after(PATIENCE_S, self.alarm)

    def on_message(self, frame: Frame) -> None:
        if frame.id == HEARTBEAT:
            self.watch.cancel()
            self.watch = self.after(PATIENCE_S, self.alarm)

    def alarm(self) -> None:
        self.send(Frame(ALARM, b"\x01"))


def main() -> float:
    """Seconds from the device's failure to the alarm."""
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=250_000)
        device = bus.node("device", Device())
        bus.node("supervisor", Supervisor())
        operator = bus.node("operator", filters=[(ALARM, 0x7FF)])

        operator.expect_nothing(within=1.0)
        device.stop()
        failed_ns = lab.now_ns
        alarm = operator.expect(ALARM, within=1.0)
        delay_s = (alarm.timestamp_ns - failed_ns) / 1e9
    print(f"the device stopped at {failed_ns / 1e9:.3f} s, the alarm came {delay_s * 1000:.1f} ms later")
    return delay_s


if __name__ == "__main__":
    main()
