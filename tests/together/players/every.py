"""Every kind of program that the matrix plays, by its name."""

from __future__ import annotations

from tests.together.players.acan import AcanApi, AcanInt2d
from tests.together.players.candrv import CandrvHandle, CandrvWin32
from tests.together.players.dongle import DongleHost
from tests.together.players.player import Player
from tests.together.players.python_can import PythonCan
from tests.together.players.vci_v3 import VciV3
from tests.together.players.vci_v4 import VciV4
from tests.together.players.verbs import Verbs

PLAYERS: dict[str, type[Player]] = {
    made.kind: made
    for made in (
        VciV4,
        VciV3,
        AcanApi,
        AcanInt2d,
        CandrvHandle,
        CandrvWin32,
        PythonCan,
        Verbs,
        DongleHost,
    )
}
