"""Record a bus into a log that other tools read, then read it back: python examples/recording.py [LOG]"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from canwire import Frame, Lab, LogLine, NodeScript, format_log_line, parse_log_line


class Sensor(NodeScript):
    """A counter every 10 ms."""

    count = 0

    def on_start(self) -> None:
        self.every(0.010, self.report)

    def report(self) -> None:
        self.count += 1
        self.send(Frame(0x280, self.count.to_bytes(2, "big")))


def record(path: Path) -> int:
    """How many frames the log has, read back."""
    with Lab() as lab, path.open("w") as log:
        bus = lab.can_bus("can0", bit_rate=500_000)
        bus.node("sensor", Sensor())
        recorder = bus.node("recorder")
        lab.run_for(1.0)
        for frame in recorder.receive_many(1_000):
            print(format_log_line(LogLine(frame.timestamp_ns, bus.name, frame)), file=log)
        assert recorder.lost == 0
    lines = [parse_log_line(line) for line in path.read_text().splitlines()]
    print(f"{path.name}: {len(lines)} frames, the last {format_log_line(lines[-1])}")
    return len(lines)


def main(path: Path | None = None) -> int:
    """Without a name the log is gone at the end."""
    if path is not None:
        return record(path)
    with tempfile.TemporaryDirectory() as folder:
        return record(Path(folder) / "recording.log")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
