"""What the hub answers about the chips behind its lines."""

from __future__ import annotations

from canwire.boards.can.connector import CanLine
from canwire.errors import Unsupported
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.line import HeldControl
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer

answers = Answers()


@answers.to(m.GetRegisters)
def _get_registers(request: m.GetRegisters, session: Session, world: World) -> Answer:
    driver = world.can_slot(request.board, request.line).can.line.driver
    return m.Registers(tuple(driver.registers())), ()


@answers.to(m.ReadRegister)
def _read_register(request: m.ReadRegister, session: Session, world: World) -> Answer:
    driver = _controlled(session, request.handle).line.driver
    return m.Number(driver.read_register(request.address, request.reset_mode)), ()


@answers.to(m.WriteRegister)
def _write_register(request: m.WriteRegister, session: Session, world: World) -> Answer:
    driver = _controlled(session, request.handle).line.driver
    driver.write_register(request.address, request.value, request.reset_mode)
    return DONE


@answers.to(m.Sleep)
def _sleep(request: m.Sleep, session: Session, world: World) -> Answer:
    line = _controlled(session, request.handle).line
    (line.driver.sleep if request.asleep else line.driver.wake)(line.timeline.now_ns)
    return DONE


@answers.to(m.Annotate)
def _annotate(request: m.Annotate, session: Session, world: World) -> Answer:
    _controlled(session, request.handle).annotate(request.note)
    return DONE


@answers.to(m.HoldInterrupts)
def _hold_interrupts(request: m.HoldInterrupts, session: Session, world: World) -> Answer:
    world.can_slot(request.board, request.line).can.line.driver.hold(request.held)
    return DONE


def _controlled(session: Session, handle: int) -> CanLine:
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, CanSlot):
        raise Unsupported(f"{slot.name} is a LIN line")
    return slot.can
