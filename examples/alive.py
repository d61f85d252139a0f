"""A counter and a checksum for `canwire simulate`, or for a node of the bench: python examples/alive.py

canwire simulate Engine can0 --db examples/engine.dbc --plugin examples.alive:alive
"""

from __future__ import annotations

from pathlib import Path

import canwire


def alive(message: canwire.OutgoingMessage) -> None:
    """EngineData counts to 15, and ends with the sum of its other bytes."""
    if message.name == "EngineData":
        message.signals["Alive"] = message.count % 16
        message.signals["Check"] = 0
        message.signals["Check"] = sum(message.encoded()) & 0xFF


def main() -> list[str]:
    """What three cycles look like on the bus."""
    db = canwire.load_database(Path(__file__).with_name("engine.dbc"))
    with canwire.Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        tester = db.on(bus.node("tester", filters=db.acceptance("EngineData")))
        bus.node("engine", db.simulated("Engine", plugins=[alive]))
        lab.run_for(0.025)
        seen = [str(message) for message in tester.decoded()]
    print("\n".join(seen))
    return seen


if __name__ == "__main__":
    main()
