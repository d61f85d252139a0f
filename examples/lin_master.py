"""A LIN master and its slaves from a description file: python examples/lin_master.py [LDF]

Needs canwire[lin].
"""

from __future__ import annotations

import sys
from pathlib import Path

from canwire import Lab, ldf

DOOR = Path(__file__).parent / "door.ldf"


def main(path: Path = DOOR) -> list[dict[str, object]]:
    """The states of the left window while it goes up, as the master decodes them."""
    network = ldf.load(path)
    states = []
    with Lab() as lab:
        bus = lab.lin_bus("lin0", bit_rate=network.bit_rate)
        master = bus.master(
            network.master, schedule=network.schedules, responses=network.responses(network.master)
        )
        slaves = {name: bus.slave(name, **network.slave_options(name)) for name in network.slaves}
        master.schedule.start("Resolve")  # asks both windows in turn
        for position in (0, 40, 80):
            answer = network.encode("LeftState", {"LeftPosition": position, "LeftMoving": 1})
            slaves["left"].respond(answer.id, answer.data)
            master.receive_many(100)  # what was heard before
            frame = master.expect(answer.id, within=0.5)
            states.append(network.decode(frame))
            print(f"{frame.timestamp_ns / 1e6:7.2f} ms  {states[-1]}")
    return states


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
