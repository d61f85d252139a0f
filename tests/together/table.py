"""The matrix: what every program of every kind is told when another one does something to the line they share.

A cell is a board, who set the line up and started it, who acts, and what happens. The tables below say what the actor
is answered, how the line is afterwards, and how each kind of program sees a line that is so; docs/sharing.md shows
them. Words are the interfaces' own; nothing is left empty: what an interface has no call for is NO_CALL, what a board
cannot do is in REFUSES.
"""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from tests.together.players.player import DONE, NO_CALL

V4, V3, ACAN, INT2D = "vci v4", "vci v3", "acan", "acan int 2dh"
CANDRV, WIN32, PYTHON, VERBS, DONGLE = (
    "candrv",
    "candrv win32",
    "python-can",
    "canwire dump/send",
    "dongle host",
)
KINDS = (V4, V3, ACAN, INT2D, CANDRV, WIN32, PYTHON, VERBS, DONGLE)

HOLDS = frozenset({V4, V3, DONGLE})
"""Keep the line's control as long as they run; all others have it for the length of a call."""
KIN = {V4: "VCI", V3: "VCI", ACAN: "ACAN", INT2D: "ACAN", CANDRV: "CANDRV", WIN32: "CANDRV"}
"""Whose programs may set each other's running lines up at another rate: their manuals say so."""

FD, PLAIN, DONGLES_OWN = "usb-to-can-fd", "usb-to-can", "canbus-dongle"
SJA1000_BOARDS = ("inducan104", "pc-i04", "netdcu", DONGLES_OWN)
BOARDS = (FD, PLAIN, *SJA1000_BOARDS[:3], "picocom1", DONGLES_OWN)
EVERY_PAIR = (FD, "inducan104", "picocom1", DONGLES_OWN)
"""One board for each kind of controller has every pair of programs; on the others each program starts and acts once."""


class Line(Enum):
    """How the line is."""

    ON = "on the bus"
    OFF = "stopped"
    UNSET = "not set up"
    BUS_OFF = "bus-off"
    GONE = "board pulled"


class Told(NamedTuple):
    """What the actor is answered: the control is free, the starter holds it, it is free and the starter is of its kin.

    `after` is how the line is where the answer is DONE.
    """

    free: str
    held: str
    kin: str
    after: Line


def _all(answer: str, after: Line) -> Told:
    return Told(answer, answer, answer, after)


JOIN_RUNNING, JOIN_STOPPED = "joins a running line", "joins a stopped line"
SET_RATE, TAKE_CONTROL = "sets another rate", "takes control"
STOP, RESET, RECOVER = "stops the line", "resets the line", "recovers from bus-off"
ENDS, KILLED, PULLED = "the starter ends", "the starter is killed", "board pulled and plugged"

_VCI_DENIED, _CANDRV_DENIED = "VCI_E_ACCESSDENIED", "ERROR_SHARING_VIOLATION"
_NEVER = _all(NO_CALL, Line.ON)

EVENTS: dict[str, dict[str, Told]] = {
    JOIN_RUNNING: {kind: _all(DONE, Line.ON) for kind in KINDS} | {DONGLE: _all("InUse", Line.ON)},
    # a listener of VCI or ACAN waits for whoever starts the line; the others start it as it is set up
    JOIN_STOPPED: {
        V4: _all(DONE, Line.OFF),
        V3: _all(DONE, Line.OFF),
        ACAN: _all(DONE, Line.OFF),
        INT2D: _all(DONE, Line.OFF),
        CANDRV: Told(DONE, DONE, DONE, Line.ON),
        WIN32: Told(DONE, DONE, DONE, Line.ON),
        PYTHON: Told(DONE, "CanInitializationError", DONE, Line.ON),
        VERBS: Told(DONE, "InUse", DONE, Line.ON),
        DONGLE: _all("InUse", Line.OFF),
    },
    SET_RATE: {
        V4: Told(_VCI_DENIED, _VCI_DENIED, _VCI_DENIED, Line.ON),
        V3: Told(_VCI_DENIED, _VCI_DENIED, _VCI_DENIED, Line.ON),
        ACAN: Told("FALSE", "FALSE", DONE, Line.ON),
        INT2D: Told("FALSE", "FALSE", DONE, Line.ON),
        CANDRV: Told(_CANDRV_DENIED, _CANDRV_DENIED, DONE, Line.ON),
        WIN32: Told(_CANDRV_DENIED, _CANDRV_DENIED, DONE, Line.ON),
        PYTHON: _all("CanInitializationError", Line.ON),
        VERBS: _all("BadValue", Line.ON),
    },
    TAKE_CONTROL: {kind: _NEVER for kind in KINDS if kind != DONGLE}
    | {kind: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.ON) for kind in (V4, V3)},
    STOP: {
        V4: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.OFF),
        V3: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.OFF),
        ACAN: Told(DONE, "0x0101", DONE, Line.OFF),
        INT2D: Told(DONE, "0x0101", DONE, Line.OFF),
        CANDRV: _NEVER,
        WIN32: _NEVER,
        PYTHON: _NEVER,
        VERBS: Told(DONE, "InUse", DONE, Line.OFF),
    },
    # .NET's ResetLine leaves a line offline; IOCTL_CAN_INIT sets it up anew, and it goes on
    RESET: {
        V4: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.UNSET),
        V3: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.OFF),
        ACAN: _NEVER,
        INT2D: _NEVER,
        CANDRV: Told(DONE, _CANDRV_DENIED, DONE, Line.ON),
        WIN32: Told(DONE, _CANDRV_DENIED, DONE, Line.ON),
        PYTHON: _NEVER,
        VERBS: Told(DONE, "InUse", DONE, Line.UNSET),
    },
    # VCI's own means is the control, of which the manual gives a line one
    RECOVER: {kind: _all(DONE, Line.ON) for kind in KINDS if kind != DONGLE}
    | {kind: Told(DONE, _VCI_DENIED, _VCI_DENIED, Line.ON) for kind in (V4, V3)},
    ENDS: {kind: _all(DONE, Line.ON) for kind in KINDS if kind != DONGLE},
    KILLED: {kind: _all(DONE, Line.ON) for kind in KINDS if kind != DONGLE},
    PULLED: {kind: _all(DONE, Line.GONE) for kind in KINDS if kind != DONGLE},
}

_VCI_GONE = "VCI_E_DEVICE_NOT_CONNECTED"
_ACAN_SEES = {
    Line.ON: "0x0100, hi_rat 250",
    Line.OFF: "0x0100, hi_rat 250",
    Line.UNSET: "0x0000",
    Line.BUS_OFF: "SC_BUSOFF",
    Line.GONE: "0x0000",
}
_CANDRV_SEES = {
    Line.ON: "baud rate 250000",
    Line.OFF: "in configuration mode",
    Line.UNSET: "in configuration mode",
    Line.BUS_OFF: "CANBUS_EVENT_BUS_ERROR",
    Line.GONE: "ERROR_DEVICE_REMOVED",
}
SEES: dict[str, dict[Line, str]] = {
    V4: {
        Line.ON: "on the bus",
        Line.OFF: "CAN_STATUS_ININIT",
        Line.UNSET: "CAN_OPMODE_UNDEFINED",
        Line.BUS_OFF: "CAN_STATUS_BUSOFF",
        Line.GONE: _VCI_GONE,
    },
    V3: {
        Line.ON: "on the bus",
        Line.OFF: "IsInInitMode",
        Line.UNSET: "IsModeUndefined",
        Line.BUS_OFF: "IsBusOff",
        Line.GONE: _VCI_GONE,
    },
    ACAN: _ACAN_SEES,
    INT2D: _ACAN_SEES,
    CANDRV: _CANDRV_SEES,
    WIN32: _CANDRV_SEES,
    PYTHON: {
        Line.ON: "ACTIVE",
        Line.OFF: "ERROR",
        Line.UNSET: "ERROR",
        Line.BUS_OFF: "ERROR",
        Line.GONE: "CanOperationError",
    },
    VERBS: {
        Line.ON: "error active",
        Line.OFF: "stopped",
        Line.UNSET: "not initialised",
        Line.BUS_OFF: "bus off",
        Line.GONE: "NoSuchBoard",
    },
    DONGLE: {
        Line.ON: "open",
        Line.OFF: "open",
        Line.UNSET: "open",
        Line.BUS_OFF: "open",
        Line.GONE: "Unplugged",
    },
}

REFUSES: dict[tuple[str, str], str] = {
    **{
        (kind, board): "ACAN_Init 0"
        for kind in (ACAN, INT2D)
        for board in BOARDS
        if board not in SJA1000_BOARDS
    },
}
"""What a program is told that tries to open a line of a board that its interface cannot drive."""


class Cell(NamedTuple):
    board: str
    starter: str
    actor: str
    event: str

    def __str__(self) -> str:
        return f"{self.board}, {self.starter}: {self.actor}: {self.event}".replace(" ", "-")

    @property
    def told(self) -> str:
        """The actor's answer."""
        found = EVENTS[self.event][self.actor]
        if self.starter in HOLDS:
            return found.held
        return found.kin if KIN.get(self.starter, 0) == KIN.get(self.actor, 1) else found.free

    @property
    def after(self) -> Line:
        """How the line is then; a refused call changes nothing."""
        row = EVENTS[self.event][self.actor]
        before = {JOIN_STOPPED: Line.OFF, RECOVER: Line.BUS_OFF}.get(self.event, Line.ON)
        if self.event == JOIN_STOPPED and self.starter in HOLDS:
            return before  # CANDRV joins too, and leaves the start to whoever has the control
        return row.after if self.told == DONE else before


def _starters(board: str) -> list[str]:
    """Who can be first there; a dongle has a board of its own."""
    if board == DONGLES_OWN:
        return [DONGLE]
    return [kind for kind in KINDS if kind != DONGLE and (kind, board) not in REFUSES]


def _actors(board: str, event: str) -> list[str]:
    """Who can act there."""
    kinds = [kind for kind in KINDS if kind in EVENTS[event] and (kind, board) not in REFUSES]
    return kinds if board == DONGLES_OWN else [kind for kind in kinds if kind != DONGLE]


CAN_STOP = frozenset({V4, V3, ACAN, INT2D, VERBS})
"""Who can leave a line set up and stopped; a dongle that closes its channel leaves nothing set up."""


def spread(starters: list[str], actors: list[str], turn: int) -> list[tuple[str, str]]:
    """As few pairs as will do for each of them to be in one; another `turn` makes others."""
    longest = max(len(starters), len(actors)) if starters else 0
    return [(starters[k % len(starters)], actors[(k + turn) % len(actors)]) for k in range(longest)]


def _pairs(board: str, event: str, every: bool) -> list[tuple[str, str]]:
    starters = [kind for kind in _starters(board) if event != JOIN_STOPPED or kind in CAN_STOP]
    actors = _actors(board, event)
    if every:
        return [(starter, actor) for starter in starters for actor in actors]
    return spread(starters, actors, BOARDS.index(board) + list(EVENTS).index(event))


def _cells(every_pair: tuple[str, ...]) -> list[Cell]:
    return [
        Cell(board, starter, actor, event)
        for board in BOARDS
        for event in EVENTS
        for starter, actor in _pairs(board, event, board in every_pair)
    ]


CELLS = _cells(EVERY_PAIR)
SPREAD = _cells(())
"""A part of CELLS in which every program starts, and acts, in everything that happens, on every board."""


def by_starter(cells: list[Cell]) -> dict[str, list[Cell]]:
    """The cells of each board and starter, by both names."""
    found: dict[str, list[Cell]] = {}
    for cell in cells:
        found.setdefault(f"{cell.board}, {cell.starter}", []).append(cell)
    return found
