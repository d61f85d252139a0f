"""The hub's answers to requests about the controller chips of its lines."""

from __future__ import annotations

from collections.abc import Callable

from canwire.boards.can.connector import CanLine
from canwire.errors import CanwireError, Unsupported
from canwire.hub.owner.answers.lines import kin_of
from canwire.hub.owner.answers.registry import DONE, Answers
from canwire.hub.owner.deferred import Deferred
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
def _read_register(request: m.ReadRegister, session: Session, world: World) -> Answer | Deferred:
    can = _controlled(session, request.handle)

    def read() -> Answer:
        return m.Number(can.line.driver.read_register(request.address, request.reset_mode)), ()

    return _quietly(can, read) if request.reset_mode else read()


@answers.to(m.WriteRegister)
def _write_register(request: m.WriteRegister, session: Session, world: World) -> Answer | Deferred:
    can = _controlled(session, request.handle)

    def write() -> Answer:
        can.line.driver.write_register(request.address, request.value, request.reset_mode)
        world.look_at_rates(can.info.bus)  # it may be one of the bit timing's
        return DONE

    return _quietly(can, write) if request.reset_mode else write()


@answers.to(m.Sleep)
def _sleep(request: m.Sleep, session: Session, world: World) -> Answer:
    line = _controlled(session, request.handle).line
    (line.driver.sleep if request.asleep else line.driver.wake)(line.timeline.now_ns)
    return DONE


@answers.to(m.Annotate)
def _annotate(request: m.Annotate, session: Session, world: World) -> Answer:
    _controlled(session, request.handle).annotate(request.note, kin_of(session, request.handle))
    return DONE


@answers.to(m.HoldInterrupts)
def _hold_interrupts(request: m.HoldInterrupts, session: Session, world: World) -> Answer:
    world.can_slot(request.board, request.line).can.line.driver.hold(request.held)
    return DONE


def _quietly(can: CanLine, act: Callable[[], Answer]) -> Deferred:
    """Wait for the end of a frame on the wire: reset mode would abort it, and it might be received twice."""
    deferred = Deferred()

    def settle() -> None:
        try:
            deferred.settle(act())
        except CanwireError as error:
            deferred.settle(error)

    can.when_quiet(settle)
    return deferred


def _controlled(session: Session, handle: int) -> CanLine:
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, CanSlot):
        raise Unsupported(f"{slot.name} is a LIN line")
    return slot.can
