"""What the hub answers to requests about LIN lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.errors import BadFrame, Unsupported, WrongState
from canwire.hub.owner.held import HeldControl
from canwire.hub.owner.held_lin import HeldMonitor, LinSlot
from canwire.hub.owner.requests import DONE, opened
from canwire.hub.owner.requests import answer as answer
from canwire.hub.protocol import messages as m
from canwire.values.lin.record import lin_frame_of_record
from canwire.values.record import RECORD_SIZE

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session
    from canwire.hub.protocol.link import Answer


@answer.register(m.GetLinStatus)
def _get_lin_status(request: m.GetLinStatus, session: Session) -> Answer:
    slot = session.world.lin_slot(request.board, request.line)
    holder = "" if slot.control is None else slot.control.name
    return m.LinLineState(slot.lin.status(), holder, slot.exclusive), ()


@answer.register(m.InitialiseLin)
def _initialise_lin(request: m.InitialiseLin, session: Session) -> Answer:
    _slot(session, request.handle).lin.initialise(request.mode)
    return DONE


@answer.register(m.WriteLin)
def _write_lin(request: m.WriteLin, session: Session) -> Answer:
    if len(request.record) != RECORD_SIZE:
        raise BadFrame(f"a record has {RECORD_SIZE} bytes, not {len(request.record)}")
    frame = lin_frame_of_record(request.record)
    _slot(session, request.handle).lin.write(frame, send=request.send)
    return DONE


@answer.register(m.WakeLin)
def _wake_lin(request: m.WakeLin, session: Session) -> Answer:
    lin = _slot(session, request.handle).lin
    (lin.go_to_sleep if request.sleep else lin.wake_up)()
    return DONE


@answer.register(m.RunSchedule)
def _run_schedule(request: m.RunSchedule, session: Session) -> Answer:
    slot = _slot(session, request.handle)
    if request.schedule is not None and not (slot.lin.mode is not None and slot.lin.mode.master):
        raise WrongState(f"{slot.name}: initialise the line as master before it runs a schedule")
    slot.run_schedule(request.schedule, request.rounds)
    return DONE


@answer.register(m.OpenMonitor)
def _open_monitor(request: m.OpenMonitor, session: Session) -> Answer:
    slot = session.world.lin_slot(request.board, request.line)
    slot.admit_monitor(request.exclusive)
    held = HeldMonitor(slot, session, request.exclusive)
    slot.monitors.append(held)
    return opened(session, held)


@answer.register(m.SetUpMonitor)
def _set_up_monitor(request: m.SetUpMonitor, session: Session) -> Answer:
    held = session.look_up(request.handle, HeldMonitor)
    descriptors = held.set_up(request.mode)
    assert held.monitor is not None
    return m.ChannelOpened(held.monitor.ring.capacity, 0), descriptors


@answer.register(m.GetMonitorStatus)
def _get_monitor_status(request: m.GetMonitorStatus, session: Session) -> Answer:
    return m.MonitorState(session.look_up(request.handle, HeldMonitor).status()), ()


def _slot(session: Session, handle: int) -> LinSlot:
    """The LIN line that this control is of; raises Unsupported for a CAN line's."""
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, LinSlot):
        raise Unsupported(f"{slot.name} is a CAN line")
    return slot
