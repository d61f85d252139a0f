"""The hub's answers to requests about LIN lines."""

from __future__ import annotations

from dataclasses import replace

from canwire.errors import BadValue, CanwireError, Unsupported, WrongState
from canwire.hub.owner.answers.registry import DONE, Answers, opened
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held.lin import HeldMonitor, LinSlot
from canwire.hub.owner.held.line import HeldControl
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.lin_messages import LinConfiguration
from canwire.hub.protocol.link import Answer
from canwire.values.lin.configuration import LinNodeAttributes
from canwire.values.lin.record import lin_frame_of_record

_LONGEST_NS = 3_600_000_000_000  # of a request: 4095 bytes at 1 kbit/s take a tenth of it

answers = Answers()


@answers.to(m.GetLinStatus)
def _get_lin_status(request: m.GetLinStatus, session: Session, world: World) -> Answer:
    return lin_state(world.lin_slot(request.board, request.line), world.lateness()), ()


@answers.to(m.GetLinStatuses)
def _get_lin_statuses(request: m.GetLinStatuses, session: Session, world: World) -> Answer:
    slots = world.slots_of(request.boards)
    lateness = world.lateness()
    found = ((at, slot) for at, slot in slots if isinstance(slot, LinSlot))
    return m.LinStatuses(tuple((*at, lin_state(slot, lateness)) for at, slot in found)), ()


def lin_state(slot: LinSlot, lateness: tuple[int, int] = (0, 0)) -> m.LinLineState:
    """The present state of a LIN line; `lateness` is that of the hub: behind_ns and skipped_ns."""
    holder = "" if slot.control is None else slot.control.name
    behind_ns, skipped_ns = lateness
    status = replace(slot.lin.status(), behind_ns=behind_ns, skipped_ns=skipped_ns)
    return m.LinLineState(status, holder, slot.exclusive)


@answers.to(m.InitialiseLin)
def _initialise_lin(request: m.InitialiseLin, session: Session, world: World) -> Answer:
    _slot(session, request.handle).initialise(session, request.mode)
    return DONE


@answers.to(m.WriteLin)
def _write_lin(request: m.WriteLin, session: Session, world: World) -> Answer:
    frame = lin_frame_of_record(request.record)
    _slot(session, request.handle).lin.write(frame, send=request.send)
    return DONE


@answers.to(m.WakeLin)
def _wake_lin(request: m.WakeLin, session: Session, world: World) -> Answer:
    lin = _slot(session, request.handle).lin
    (lin.go_to_sleep if request.sleep else lin.wake_up)()
    return DONE


@answers.to(m.RunSchedule)
def _run_schedule(request: m.RunSchedule, session: Session, world: World) -> Answer:
    slot = _slot(session, request.handle)
    if request.schedule is not None and not (slot.lin.mode is not None and slot.lin.mode.master):
        raise WrongState(f"{slot.name}: initialise the line as master before it runs a schedule")
    slot.run_schedule(request.schedule, request.rounds)
    return DONE


@answers.to(m.ConfigureLin)
def _configure_lin(request: m.ConfigureLin, session: Session, world: World) -> Answer:
    attributes = LinNodeAttributes(
        request.product,
        request.nad,
        request.frames,
        request.serial,
        request.identifiers,
        request.message_ids,
        p2_ns=request.p2_ns,
        n_as_ns=request.n_as_ns,
        n_cr_ns=request.n_cr_ns,
    )
    _slot(session, request.handle).configure(attributes)
    return DONE


@answers.to(m.GetLinConfiguration)
def _get_lin_configuration(request: m.GetLinConfiguration, session: Session, world: World) -> Answer:
    slave = _slot(session, request.handle).slave
    if request.power_up:
        slave.power_up()
    return LinConfiguration(slave.configuration.nad, dict(slave.configuration.identifiers)), ()


@answers.to(m.RequestLin)
def _request_lin(request: m.RequestLin, session: Session, world: World) -> Deferred:
    deferred = Deferred()

    def answered(result: bytes | CanwireError) -> None:
        deferred.settle(result if isinstance(result, CanwireError) else (m.Note(result), ()))

    if not 0 < request.within_ns <= _LONGEST_NS:
        raise BadValue(f"within {request.within_ns / 1e9} s: above 0, and {_LONGEST_NS // 10**9} s at most")
    _slot(session, request.handle).request(request.nad, request.payload, request.within_ns, answered)
    return deferred


@answers.to(m.OpenMonitor)
def _open_monitor(request: m.OpenMonitor, session: Session, world: World) -> Answer:
    session.check_room(HeldMonitor)
    slot = world.lin_slot(request.board, request.line)
    slot.admit_queue(request.exclusive)
    held = HeldMonitor(slot, session, request.exclusive)
    slot.queues.append(held)
    return opened(session, held)


@answers.to(m.SetUpMonitor)
def _set_up_monitor(request: m.SetUpMonitor, session: Session, world: World) -> Answer:
    held = session.look_up(request.handle, HeldMonitor)
    descriptors = held.set_up(request.mode)
    assert held.monitor is not None
    return m.ChannelOpened(held.monitor.ring.capacity, 0), descriptors


@answers.to(m.GetMonitorStatus)
def _get_monitor_status(request: m.GetMonitorStatus, session: Session, world: World) -> Answer:
    return m.MonitorState(session.look_up(request.handle, HeldMonitor).status()), ()


def _slot(session: Session, handle: int) -> LinSlot:
    """The LIN line that this control is of; raises Unsupported for a CAN line's."""
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, LinSlot):
        raise Unsupported(f"{slot.name} is a CAN line")
    return slot
