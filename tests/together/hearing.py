"""What each kind of program is told of what happens on a line, whoever set the line up: in its interface's own words.

The columns are those of docs/sharing.md. A word of NO_CALL says that the interface knows nothing of the kind.
"""

from __future__ import annotations

from typing import NamedTuple

from tests.together import table
from tests.together.players.player import NO_CALL
from tests.together.table import ACAN, CANDRV, DONGLE, INT2D, KINDS, PYTHON, V3, V4, VERBS, WIN32

HELD = "cannot be: it has the control"


class Hears(NamedTuple):
    """What tells of a bus error, of error warning, of lost arbitration; what sets its filter; what tells of a stop."""

    errors: str
    states: str
    losses: str
    filter: str
    stopped: str


_ACAN = Hears("SC_BUSERR", "SC_ERRLIM", "SC_ARBLOST", "hi_miv, hi_mim", "SC_BUSOFF")
_CANDRV = Hears(
    NO_CALL,
    "CANBUS_EVENT_WARNING",
    "CANBUS_EVENT_ARBITRATION_LOST",
    "WRITE_ACCEPTANCE_FILTER",
    "CANBUS_EVENT_DEVICE_CHANGED",
)
HEARS: dict[str, Hears] = {
    V4: Hears("CAN_MSGTYPE_ERROR", "CAN_MSGTYPE_STATUS", NO_CALL, "SetAccFilter", "CAN_INFO_STOP"),
    V3: Hears("ERROR", "STATUS", NO_CALL, "SetAccFilter", "STOP"),
    ACAN: _ACAN,
    INT2D: _ACAN,
    CANDRV: _CANDRV,
    WIN32: _CANDRV,
    PYTHON: Hears("CAN_ERR_BUSERROR", "CAN_ERR_CRTL", "CAN_ERR_LOSTARB", "set_filters", "CanOperationError"),
    VERBS: Hears("ERROR", "STATE", NO_CALL, NO_CALL, "STATE"),
    DONGLE: Hears("BEI", "EI", "ALI", "M, m", HELD),
}
"""python-can hears of a stop when it sends; a dongle's host closes its channel by itself alone."""

_COMPANIES = ((V4, ACAN, CANDRV, PYTHON), (V3, INT2D, WIN32, VERBS))
"""Who joins together: one program of each interface. CANDRV lets in two readers of a PicoCOM."""


class Company(NamedTuple):
    """On a board, who sets the line up and who joins it."""

    board: str
    starter: str
    joiners: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.board}, {self.starter}: {', '.join(self.joiners)}".replace(" ", "-")


def _companies() -> list[Company]:
    return [
        Company(board, starter, tuple(kind for kind in kinds if (kind, board) not in table.REFUSES))
        for board in table.BOARDS
        for starter in KINDS
        if (starter, board) not in table.REFUSES and (starter == DONGLE) == (board == table.DONGLES_OWN)
        for kinds in _COMPANIES
    ]


COMPANIES = _companies()
