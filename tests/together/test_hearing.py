"""What a program hears belongs to that program: every starter with every joiner, on every board, in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import ChannelMode, Frame, candrv, vci
from canwire.acan import service
from canwire.candrv.device import device
from tests.cases import hold_for_each
from tests.together import table
from tests.together.hearing import COMPANIES, HEARS, Company, Hears
from tests.together.players.acan import AcanApi
from tests.together.players.candrv import REGISTRY, CandrvHandle
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE, NO_CALL, RATE, Player
from tests.together.players.vci_v4 import VciV4
from tests.together.scene import PROVOKED, Scene, virtual_scene
from tests.together.table import HOLDS, KIN

_A_WHILE_S = 0.02
_WITHIN, _OUTSIDE = 0x250, 0x150  # of the identifiers that a narrow program wants
_TO_WARNING = 13  # bit errors while sending, of 8 each


@pytest.fixture(autouse=True)
def program_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """CID1: is the shared line; nobody waits long for a control that stays taken."""
    path = tmp_path / "canwire.toml"
    path.write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(path))
    monkeypatch.setattr(service, "_PAUSES_S", (0.0,))
    monkeypatch.setattr(device, "_PAUSES_S", (0.0,))


def test_no_cell_is_empty() -> None:
    assert set(HEARS) == set(table.KINDS)
    assert all(word for words in HEARS.values() for word in words)
    pairs = {(one.board, one.starter, kind) for one in COMPANIES for kind in one.joiners}
    for board in table.BOARDS:
        there = {kind for kind in table.KINDS if (kind, board) not in table.REFUSES} - {table.DONGLE}
        first = {table.DONGLE} if board == table.DONGLES_OWN else there
        assert {(starter, kind) for on, starter, kind in pairs if on == board} == {
            (starter, kind) for starter in first for kind in there
        }


@pytest.mark.parametrize("board", table.BOARDS)
@pytest.mark.conforms("N-03", "N-63")
@pytest.mark.finding("dialects 1", "dialects 7")
def test_each_hears_what_it_asked_for(board: str) -> None:
    hold_for_each([one for one in COMPANIES if one.board == board], _play)


def _play(company: Company) -> None:
    with virtual_scene(company.board) as scene:
        starter = scene.play(PLAYERS[company.starter])
        assert starter.set_up() == DONE
        narrow = starter.narrow()
        assert (narrow == NO_CALL) == (HEARS[starter.kind].filter == NO_CALL)
        joiners = [scene.play(PLAYERS[kind]) for kind in company.joiners]
        assert [joiner.join() for joiner in joiners] == [DONE] * len(joiners)
        _hear_all(scene, starter, joiners)
        for joiner in sorted(joiners, key=lambda one: one.kind in HOLDS):  # and keep the control from then on
            _set_up_anew(company, starter, joiner)
        _hear_all(scene, starter, joiners)
        _stop(scene, starter, joiners)


def _hear_all(scene: Scene, starter: Player, joiners: list[Player]) -> None:
    programs = [starter, *joiners]
    for what in ("errors", "states", "losses"):
        for program in programs:
            program.told()
        _provoke(scene, what)
        missed = [
            one.kind for one in programs if not _is_told(one, getattr(HEARS[one.kind], what), one.told())
        ]
        assert not missed, f"{what}: {missed}"
    _calm(scene)
    for program in programs:
        program.received()
    scene.peer.send(_OUTSIDE)
    scene.peer.send(_WITHIN)
    scene.hub.run_for(_A_WHILE_S)
    wanted = [_OUTSIDE, _WITHIN] if HEARS[starter.kind].filter == NO_CALL else [_WITHIN]
    assert starter.received() == wanted
    others = [
        one
        for one in joiners
        if KIN.get(one.kind, "") not in ("VCI", "ACAN") or KIN.get(starter.kind) != KIN[one.kind]
    ]
    assert {one.kind: one.received() for one in others} == {one.kind: [_OUTSIDE, _WITHIN] for one in others}


def _is_told(program: Player, word: str, told: set[str]) -> bool:
    return word == NO_CALL or word in told


def _provoke(scene: Scene, what: str) -> None:
    """One bit error, a dozen of them, or a frame that meets a more urgent one."""
    with scene.hub.open_channel(scene.board.id, 0) as channel:
        channel.set_up(ChannelMode(1, 8, frames=False))
        channel.activate()
        if what == "losses":
            scene.peer.send(0x010)
            channel.send(Frame(0x7F0))
        else:
            times = 1 if what == "errors" else _TO_WARNING
            scene.hub.bus("can0").faults.inject("bit", frame_id=PROVOKED, times=times)
            channel.send(Frame(PROVOKED))
        scene.hub.run_for(_A_WHILE_S)


def _calm(scene: Scene) -> None:
    """Let the line send until its counters are back at 0."""
    with scene.hub.open_channel(scene.board.id, 0) as channel:
        channel.set_up(ChannelMode(1, 256, frames=False))
        channel.activate()
        for _ in range(scene.status().tec):
            channel.send(Frame(0x011))
        assert scene.until(lambda: scene.status().tec == 0)


def _set_up_anew(company: Company, starter: Player, joiner: Player) -> None:
    """As it does for itself, at the rate that is there; one whose control is taken is refused, and changes nothing."""
    if joiner.kind not in KIN or KIN[joiner.kind] == KIN.get(starter.kind):
        return
    told = joiner.reset() if KIN.get(joiner.kind) == "CANDRV" else joiner.set_rate(RATE)
    loses_fd = (company.board, joiner.kind) == (table.FD, table.V3) and starter.kind not in KIN
    assert (told != DONE) == (loses_fd or starter.kind in HOLDS), (joiner.kind, told)


def _stop(scene: Scene, starter: Player, joiners: list[Player]) -> None:
    """By whoever has the control now, and if need be by closing the dongle's channel."""
    stopper = starter if starter.kind in HOLDS else next(one for one in joiners if one.kind in HOLDS)
    others = [one for one in (starter, *joiners) if one is not stopper]
    for one in others:
        one.told()
    assert stopper.stop() == DONE
    scene.hub.run_for(_A_WHILE_S)
    for one in others:
        words = one.told() or {one.send(0x123)}
        assert _stopped_word(stopper, HEARS[one.kind]) in words, (one.kind, words)


def _stopped_word(stopper: Player, hears: Hears) -> str:
    """A dongle's host that closes its channel resets its line."""
    reset = {"CAN_INFO_STOP": "CAN_INFO_RESET", "STOP": "RESET"}
    return reset.get(hears.stopped, hears.stopped) if stopper.kind == table.DONGLE else hears.stopped


@pytest.mark.finding("dialects 6")
def test_acan_begins_again_off_the_bus() -> None:
    """docs/porting-acan.md, Troubles: after ACAN_Exit nobody is on the line, which leaves its bus and stays set up."""
    with virtual_scene("inducan104") as scene:
        program = scene.play(AcanApi)
        assert program.set_up() == DONE
        library = program._api
        library.ACAN_Exit()
        library.use(program.hub)
        assert library.ACAN_Init()
        assert (library.ACAN_GetInitStatus() != 0, scene.status().running) == (True, False)
        assert scene.send(program) == "lost"
        assert library.ACAN_BusControl(1) == 0x0001
        assert scene.send(program) == DONE
        assert [one.aborted for one in [library._LIBRARY.driver._line._channel.status()]] == [1]


@pytest.mark.parametrize("board", [table.FD, "inducan104", "picocom1"])
@pytest.mark.finding("dialects 1")
@pytest.mark.conforms("N-63")
def test_candrvs_init_leaves_vcis_settings_alone(board: str) -> None:
    """Operating mode, bit timing and line filter as InitLine and SetAccFilter set them, byte for byte."""
    with virtual_scene(board) as scene:
        starter = scene.play(PLAYERS[table.VERBS])
        assert starter.set_up() == DONE
        vci_program, candrv_program = scene.play(VciV4), scene.play(CandrvHandle)
        assert (vci_program.set_rate(RATE), vci_program.join()) == (DONE, DONE)
        assert vci_program.narrow() == DONE
        vci_program._control.release()
        vci_program._control = None
        socket = vci_program._program.open(vci.IID_ICanSocket, 0, scene.board.hardware_id)
        before = socket.get_line_status().to_bytes()
        assert socket.get_line_status().op_mode == 0x07  # STANDARD, EXTENDED, ERRFRAME
        assert candrv_program.join() == DONE
        assert candrv_program.reset() == DONE
        assert socket.get_line_status().to_bytes() == before
        scene.peer.send(_OUTSIDE)
        scene.peer.send(_WITHIN)
        scene.hub.run_for(_A_WHILE_S)
        assert (vci_program.received(), candrv_program.received()) == ([_WITHIN], [_OUTSIDE, _WITHIN])


@pytest.mark.finding("dialects 1")
@pytest.mark.conforms("N-63")
def test_vcis_start_leaves_candrvs_mode_alone() -> None:
    """CAN2.0A of a CANDRV program, which hears no 29-bit frames, is no setting of VCI's."""
    with virtual_scene("inducan104") as scene:
        starter, joiner = scene.play(CandrvHandle), scene.play(VciV4)
        assert (starter.set_up(), joiner.join()) == (DONE, DONE)
        starter._handle.can_mode = candrv.CanMode.CAN_2_0_A
        assert joiner.set_rate(RATE) == DONE
        assert starter._handle.can_mode == candrv.CanMode.CAN_2_0_A


@pytest.mark.finding("dialects 1")
def test_what_vci_set_ends_with_its_last_program() -> None:
    """On a line that others go on using the next VCI program finds nothing of it."""
    with virtual_scene("inducan104") as scene:
        stays, leaves = scene.play(PLAYERS[table.PYTHON]), scene.play(VciV4)
        assert (stays.set_up(), leaves.set_rate(RATE), leaves.join(), leaves.narrow()) == (DONE,) * 4
        leaves.end()
        comes = scene.play(VciV4)
        assert comes.join() == DONE
        assert scene.hear(stays, comes)
