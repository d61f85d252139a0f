"""Boards that are real adapters: each has a private bus and a port; their kinds are named after their drivers.

Their input comes from outside the timeline, so they need a hub whose time passes by itself.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import replace
from importlib.util import find_spec

from canwire.boards.board import Board, BoardLine
from canwire.boards.can.line import Line
from canwire.boards.description import BoardInfo, Capabilities, Feature
from canwire.boards.figures import ADAPTER, FD_ADAPTER
from canwire.boards.kinds import KINDS, PYTHON_CAN, SLCAN, SLCAN_FD
from canwire.bus.can.node import Bus, Node
from canwire.drivers.outside import Identity, OutsideDriver, Reactor
from canwire.drivers.python_can import port as python_can_port
from canwire.drivers.python_can.backends import backend
from canwire.drivers.python_can.driver import PythonCanDriver
from canwire.drivers.slcan_dongle.driver import SlcanDriver
from canwire.drivers.slcan_dongle.port import parse_port
from canwire.errors import BadValue, ExtraMissing, InUse, NoSuchBoard, Unsupported
from canwire.timeline import Timeline

SERIAL = (SLCAN, SLCAN_FD)


def checked_port(kind: str, port: str) -> str:
    """Return the port if boards of this kind can be there; raises BadValue."""
    if kind not in KINDS or not KINDS[kind].outside:
        if port:
            raise BadValue(f"{kind} has no port; {', '.join(SERIAL)} and {PYTHON_CAN} have")
    elif not port:
        where = "/dev/ttyUSB0 perhaps" if kind in SERIAL else "pcan/PCAN_USBBUS1 perhaps"
        raise BadValue(f"{kind}: its port is missing: {where}")
    elif kind in SERIAL:
        parse_port(port)
    else:
        python_can_port.parse_port(port)
    return port


def check_port(kind: str, port: str) -> None:
    """Check before plugging in by hand that the port exists; raises NoSuchBoard, ExtraMissing, BadValue."""
    checked_port(kind, port)
    if kind in SERIAL:
        url = parse_port(port).url
        if not url.startswith("socket://") and find_spec("serial") is None:
            raise ExtraMissing("pyserial", "hardware")
        if url.startswith("/") and not os.path.exists(url):
            raise NoSuchBoard(f"{kind}: no port {url}; plug the adapter in first")
    elif kind == PYTHON_CAN and find_spec("can") is None:
        raise ExtraMissing("python-can", "hardware")


def check_unused(port: str, boards: Iterable[Board]) -> None:
    """Raise InUse with the name of the board that uses this port already."""
    for board in boards:
        for slot in board.lines:
            driver = slot.line.driver
            if isinstance(driver, OutsideDriver) and driver.port == port:
                raise InUse(
                    f"{port} is {board.info.hardware_id}'s ({board.info.kind}) already; use that board"
                )


def outside_board(info: BoardInfo, port: str, timeline: Timeline, reactor: Reactor | None) -> Board:
    """A board for the adapter at this port, which may be connected later. Raises Unsupported in virtual time."""
    if reactor is None:
        raise Unsupported(
            f"{info.kind}: a real adapter does not wait for virtual time; use a hub in real time"
        )
    line = Line(f"{info.hardware_id}:0", timeline)
    driver: OutsideDriver
    if info.kind in SERIAL:
        driver = SlcanDriver(line, port, timeline, reactor)
    else:
        driver = PythonCanDriver(line, port, timeline, reactor)
        known = replace(info.lines[0], capabilities=capabilities_of(port))
        info = replace(info, lines=(known,))
    line.connect(driver, Node())
    info = replace(info, resources=(("Port", port),))
    return Board(info, (BoardLine(info.lines[0], line, Bus()),))


def capabilities_of(port: str) -> Capabilities:
    """The known capabilities of the python-can interface at this port, before it is opened."""
    known = backend(python_can_port.parse_port(port).interface)
    figures = ADAPTER if known.fd is None else FD_ADAPTER
    if known.listen_only is None:
        return figures
    return replace(figures, features=figures.features | Feature.LISTEN_ONLY)


def when_heard_of(
    board: Board, identified: Callable[[Identity], object], tell: Callable[[str], object]
) -> None:
    """Set the calls of a real adapter: `identified`, soon and perhaps several times, and `tell` with the reason if it
    cannot be reached.
    """
    for slot in board.lines:
        driver = slot.line.driver if isinstance(slot, BoardLine) else None
        if isinstance(driver, OutsideDriver):
            where = f"{board.info.hardware_id} at {driver.port}"
            driver.on_identified = identified
            driver.on_obstacle = lambda why, where=where: tell(f"{where}: {why}; the hub waits for it")


def obstacle_of(line: Line) -> str:
    """The reason why a real adapter does not take part in its bus; "" for every other line."""
    return line.driver.obstacle() if isinstance(line.driver, OutsideDriver) else ""


def identified(info: BoardInfo, identity: Identity) -> BoardInfo:
    """A board's description with the identity that its adapter reports."""
    return replace(
        info,
        resources=identity.facts,
        hardware_version=identity.hardware_version,
        firmware_version=identity.firmware_version,
    )
