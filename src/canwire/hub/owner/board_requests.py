"""What the hub answers to requests about chips, shares and notes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.boards.can.connector import CanLine
from canwire.boards.sharing import Share
from canwire.errors import BadValue, Unsupported
from canwire.hub.owner.held import HeldControl, HeldShare, Slot
from canwire.hub.owner.requests import DONE, answer, opened
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session

_SHARE_MODES = range(4)


@answer.register(m.OpenShare)
def _open_share(request: m.OpenShare, session: Session) -> Answer:
    slot = session.world.slot(request.board, request.line)
    if request.share not in _SHARE_MODES:
        raise BadValue(f"share mode {request.share}: 1 for reading, 2 for writing, 3 both, 0 none")
    share = Share(session.name, request.read, request.write, request.share)
    slot.sharing.open(share)
    return opened(session, HeldShare(slot, share))


@answer.register(m.ReadRegister)
def _read_register(request: m.ReadRegister, session: Session) -> Answer:
    driver = _controlled(session, request.handle).line.driver
    return m.Number(driver.read_register(request.address, request.reset_mode)), ()


@answer.register(m.WriteRegister)
def _write_register(request: m.WriteRegister, session: Session) -> Answer:
    driver = _controlled(session, request.handle).line.driver
    driver.write_register(request.address, request.value, request.reset_mode)
    return DONE


@answer.register(m.Sleep)
def _sleep(request: m.Sleep, session: Session) -> Answer:
    line = _controlled(session, request.handle).line
    (line.driver.sleep if request.asleep else line.driver.wake)(line.timeline.now_ns)
    return DONE


@answer.register(m.HoldInterrupts)
def _hold_interrupts(request: m.HoldInterrupts, session: Session) -> Answer:
    session.world.slot(request.board, request.line).can.line.driver.hold(request.held)
    return DONE


def _controlled(session: Session, handle: int) -> CanLine:
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, Slot):
        raise Unsupported(f"{slot.name} is a LIN line")
    return slot.can


@answer.register(m.GetRegisters)
def _get_registers(request: m.GetRegisters, session: Session) -> Answer:
    driver = session.world.slot(request.board, request.line).can.line.driver
    return m.Registers(tuple(driver.registers())), ()


# notes


@answer.register(m.GetNote)
def _get_note(request: m.GetNote, session: Session) -> Answer:
    return m.Note(session.world.notes.get(request.name, b"")), ()


@answer.register(m.SetNote)
def _set_note(request: m.SetNote, session: Session) -> Answer:
    session.world.set_note(request.name, request.value)
    return DONE
