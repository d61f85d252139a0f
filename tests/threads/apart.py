"""The shapes as three programs in processes of their own, on a hub in lockstep."""

from __future__ import annotations

from pathlib import Path

from tests.lockstep.programs import bench

START = f"import can, runpy\nshapes = runpy.run_path({str(Path(__file__).with_name('shapes.py'))!r})\n"
OPEN = 'can.Bus("can0", interface="canwire", bitrate=500_000)'
TESTER = f"{START}with {OPEN} as bus:\n    print(*shapes['tester'](bus), sep='\\n')\n"


def ecu(shape: str, number: int) -> str:
    return f"{START}with {OPEN} as bus:\n    shapes['SHAPES'][{shape!r}](bus, {number})\n"


def played_apart(home: Path, first: str, second: str, remote: tuple[str, ...] = ()) -> list[str]:
    """The tester's log of an ECU of each of these shapes; those of `remote` reach the hub over the network."""
    with bench(home, "--programs", "ecu1,ecu2,tester", "--patience", "60") as made:
        if remote:
            made.offered(remote)
        programs = {"ecu1": ecu(first, 1), "ecu2": ecu(second, 2), "tester": TESTER}
        return made.run(programs)["tester"].splitlines()
