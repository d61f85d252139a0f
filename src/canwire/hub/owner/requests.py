"""What the hub answers to each request, one function each."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from canwire.boards.can.connector import CanLine
from canwire.boards.can.cyclic_object import Increment
from canwire.boards.can.message_filter import FormatFilter
from canwire.boards.can.modes import CyclicStatus, FilterMode
from canwire.boards.can.scheduler import CyclicList
from canwire.boards.description import Feature
from canwire.boards.inducan104 import checked_place
from canwire.boards.lin.line import LinLine
from canwire.boards.outside import check_port
from canwire.errors import (
    BadFilter,
    BadFrame,
    BadMessage,
    BadValue,
    CanwireError,
    HubError,
    InUse,
    NoSuchBoard,
    Unsupported,
    WrongState,
)
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held import HeldControl, HeldLayer, HeldPipe, HeldScheduler, OnLine, Slot
from canwire.hub.owner.held_channel import HeldChannel
from canwire.hub.owner.held_lin import HeldMonitor, LinSlot
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.timeline import NEVER, Timeline
from canwire.values.frame import Frame, frame_of_record
from canwire.values.record import HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT

if TYPE_CHECKING:
    from canwire.hub.owner.session import Session

_CYCLIC_FLAGS = SINGLE_SHOT | HIGH_PRIORITY | SELF_RECEPTION
_LARGEST_NS = 1 << 62
_KIND_AT = 12  # byte of a record: 0 for frames
DONE: Answer = (m.Done(), ())


@singledispatch
def answer(request: Any, session: Session) -> Answer | Deferred:
    """The answer to a request of this client; raises CanwireError."""
    raise BadMessage(f"{type(request).__name__} is no request for a session")


# boards


@answer.register(m.ListBoards)
def _list_boards(request: m.ListBoards, session: Session) -> Answer:
    return m.Boards(session.world.infos()), ()


@answer.register(m.Watch)
def _watch(request: m.Watch, session: Session) -> Answer:
    session.watching = True
    return DONE


@answer.register(m.Plug)
def _plug(request: m.Plug, session: Session) -> Answer:
    place = None
    if request.base is not None or request.irq is not None or request.shared_irq:
        place = checked_place(request.base, request.irq, request.shared_irq)
    check_port(request.kind, request.port)
    board = session.world.plug(request.kind, request.serial, request.buses, place, port=request.port)
    return m.Plugged(board), ()


@answer.register(m.Unplug)
def _unplug(request: m.Unplug, session: Session) -> Answer:
    session.world.unplug(request.hardware_id)
    return DONE


@answer.register(m.OpenLayer)
def _open_layer(request: m.OpenLayer, session: Session) -> Answer:
    board = session.world.board(request.board)
    for other in session.world.sessions:
        for layer in other.held(HeldLayer):
            if layer.board == request.board and layer.layer != request.layer:
                raise InUse(f"{board.info.hardware_id}: layer {layer.layer!r} is open, by {other.name}")
    return opened(session, HeldLayer(request.board, request.layer))


# leases


@answer.register(m.OpenControl)
def _open_control(request: m.OpenControl, session: Session) -> Answer:
    slot = session.world.line_slot(request.board, request.line)
    slot.admit("its control", slot.control)
    slot.control = session
    return opened(session, HeldControl(slot))


@answer.register(m.OpenChannel)
def _open_channel(request: m.OpenChannel, session: Session) -> Answer:
    slot = session.world.slot(request.board, request.line)
    slot.admit_channel(request.exclusive)
    held = HeldChannel(slot, session, request.exclusive)
    slot.channels.append(held)
    return opened(session, held)


@answer.register(m.OpenScheduler)
def _open_scheduler(request: m.OpenScheduler, session: Session) -> Answer:
    slot = session.world.slot(request.board, request.line)
    ticks = slot.can.info.capabilities.cyclic
    if not slot.can.info.capabilities.can(Feature.SCHEDULER):
        raise Unsupported(f"{slot.can.line.name} has no cyclic transmit list")
    slot.admit("its cyclic list", slot.scheduler)
    slot.scheduler = session
    cyclic = CyclicList(slot.can.line, session.world.timeline, ticks.tick_ns, ticks.maximum)
    return opened(session, HeldScheduler(slot, cyclic))


@answer.register(m.Close)
def _close(request: m.Close, session: Session) -> Answer:
    session.look_up(request.handle, object)
    session.release(request.handle)
    return DONE


# a line


@answer.register(m.GetLineStatus)
def _get_line_status(request: m.GetLineStatus, session: Session) -> Answer:
    return m.LineState(session.world.slot(request.board, request.line).status()), ()


@answer.register(m.Initialise)
def _initialise(request: m.Initialise, session: Session) -> Deferred:
    can = _control(session, request.handle)
    return _later(lambda done: can.initialise(request.mode, done), numbered=False)


@answer.register(m.Start)
def _start(request: m.Start, session: Session) -> Answer:
    can = _commanded(session, request.handle)
    if request.abort_pending and isinstance(can, CanLine):
        can.abort_pending()
    can.start()
    return DONE


@answer.register(m.Stop)
def _stop(request: m.Stop, session: Session) -> Deferred:
    return _later(_commanded(session, request.handle).stop, numbered=False)


@answer.register(m.Reset)
def _reset(request: m.Reset, session: Session) -> Answer:
    _commanded(session, request.handle).reset()
    return DONE


@answer.register(m.Detect)
def _detect(request: m.Detect, session: Session) -> Deferred:
    can = _control(session, request.handle)
    return _later(
        lambda done: can.detect(
            request.candidates, request.timeout_ms, request.iso_fd, done, low_speed=request.low_speed
        ),
        numbered=True,
    )


# filters


@answer.register(m.GetFilterMode)
def _get_filter_mode(request: m.GetFilterMode, session: Session) -> Answer:
    return m.Number(_filter(session, request.handle, request.extended).mode), ()


@answer.register(m.SetFilterMode)
def _set_filter_mode(request: m.SetFilterMode, session: Session) -> Answer:
    found = _filter(session, request.handle, request.extended, change=True)
    if request.mode not in (
        FilterMode.LOCK,
        FilterMode.PASS,
        FilterMode.INCLUSIVE,
        FilterMode.EXCLUSIVE,
    ):
        raise BadFilter(f"filter mode {request.mode}: 1 lock, 2 pass, 3 inclusive, 4 exclusive")
    before, found.mode = found.mode, request.mode
    return m.Number(before), ()


@answer.register(m.SetAcceptanceFilter)
def _set_acceptance_filter(request: m.SetAcceptanceFilter, session: Session) -> Answer:
    _filter(session, request.handle, request.extended, change=True).set_pattern(request.code, request.mask)
    return DONE


@answer.register(m.ListIds)
def _list_ids(request: m.ListIds, session: Session) -> Answer:
    found = _filter(session, request.handle, request.extended, change=True)
    (found.add if request.add else found.remove)(request.code, request.mask)
    return DONE


# channels


@answer.register(m.SetUpChannel)
def _set_up_channel(request: m.SetUpChannel, session: Session) -> Answer:
    held = session.look_up(request.handle, HeldChannel)
    descriptors = held.set_up(request.mode, session.doorbell)
    assert held.channel is not None
    transmit = held.channel.transmit.capacity if held.channel.sends else 0
    return m.ChannelOpened(held.channel.receive.capacity, transmit), descriptors


@answer.register(m.Activate)
def _activate(request: m.Activate, session: Session) -> Answer:
    held = session.look_up(request.handle, OnLine)
    if not isinstance(held, (HeldChannel, HeldMonitor)):
        raise NoSuchBoard(f"handle {request.handle} is neither a channel nor a monitor of {session.name}")
    held.activate(request.active)
    return DONE


@answer.register(m.GetChannelStatus)
def _get_channel_status(request: m.GetChannelStatus, session: Session) -> Answer:
    return m.ChannelState(session.look_up(request.handle, HeldChannel).status()), ()


@answer.register(m.CancelQueued)
def _cancel_queued(request: m.CancelQueued, session: Session) -> Answer:
    held = session.look_up(request.handle, HeldChannel)
    return m.Number(0 if held.channel is None else held.slot.can.line.cancel(held.channel)), ()


# the cyclic list


@answer.register(m.AddCyclic)
def _add_cyclic(request: m.AddCyclic, session: Session) -> Answer:
    held = session.look_up(request.handle, HeldScheduler)
    owner = session.look_up(request.channel, HeldChannel).channel if request.channel else None
    frame = _cyclic_frame(request.record)
    flags = int.from_bytes(request.record[12:16], "little") & _CYCLIC_FLAGS
    if request.increment not in list(Increment):
        raise BadValue(f"increment {request.increment}: 0 none, 1 identifier, 2 byte, 3 two bytes")
    index = held.cyclic.add(
        frame,
        request.cycle,
        increment=Increment(request.increment),
        byte_index=request.byte_index,
        flags=flags,
        owner=owner,
    )
    return m.Number(index), ()


@answer.register(m.ReplaceCyclic)
def _replace_cyclic(request: m.ReplaceCyclic, session: Session) -> Answer:
    frame = _cyclic_frame(request.record)
    session.look_up(request.handle, HeldScheduler).cyclic.replace(request.index, frame)
    return DONE


@answer.register(m.StartInTurn)
def _start_in_turn(request: m.StartInTurn, session: Session) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    cyclic.start_in_turn(request.indices, request.counts, request.step)
    return DONE


@answer.register(m.RemoveCyclic)
def _remove_cyclic(request: m.RemoveCyclic, session: Session) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.remove(request.index)
    return DONE


@answer.register(m.StartCyclic)
def _start_cyclic(request: m.StartCyclic, session: Session) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.start(request.index, request.count)
    return DONE


@answer.register(m.StopCyclic)
def _stop_cyclic(request: m.StopCyclic, session: Session) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.stop(request.index)
    return DONE


@answer.register(m.RunScheduler)
def _run_scheduler(request: m.RunScheduler, session: Session) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    (cyclic.resume if request.running else cyclic.suspend)()
    return DONE


@answer.register(m.ResetScheduler)
def _reset_scheduler(request: m.ResetScheduler, session: Session) -> Answer:
    session.look_up(request.handle, HeldScheduler).cyclic.reset()
    return DONE


@answer.register(m.GetSchedulerStatus)
def _get_scheduler_status(request: m.GetSchedulerStatus, session: Session) -> Answer:
    cyclic = session.look_up(request.handle, HeldScheduler).cyclic
    return m.SchedulerState(CyclicStatus(cyclic.running, cyclic.states(), cyclic.skipped)), ()


# FIFOs, numbers, time


@answer.register(m.CreateFifo)
def _create_fifo(request: m.CreateFifo, session: Session) -> Answer:
    session.world.pipes.create(number := session.world.next_luid(), request.capacity, request.element_size)
    return _fifo(session, number, "fifo")


@answer.register(m.OpenFifo)
def _open_fifo(request: m.OpenFifo, session: Session) -> Answer:
    return _fifo(session, request.fifo, request.role)


@answer.register(m.ResetFifo)
def _reset_fifo(request: m.ResetFifo, session: Session) -> Answer:
    session.world.pipes.reset(session.look_up(request.handle, HeldPipe).pipe)
    return DONE


@answer.register(m.CreateLuid)
def _create_luid(request: m.CreateLuid, session: Session) -> Answer:
    return m.Number(session.world.next_luid()), ()


@answer.register(m.Disturb)
def _disturb(request: m.Disturb, session: Session) -> Answer:
    session.world.short(request.bus, request.shorted)
    return DONE


@answer.register(m.Advance)
def _advance(request: m.Advance, session: Session) -> Answer:
    timeline = session.world.timeline
    if session.virtual and request.span_ns > 0:
        timeline.at(timeline.now_ns, session.world.kick_all)  # as a happening, whose signals count
        end_ns = timeline.now_ns + request.span_ns
        if end_ns < _LARGEST_NS:
            timeline.run_until(end_ns)
        else:
            _run_on(timeline)
    return m.Number(timeline.now_ns), ()


# what several of them need


def opened(session: Session, held: object) -> Answer:
    return m.Opened(session.hold(held)), ()


def _cyclic_frame(record: bytes) -> Frame:
    """Raises BadFrame for an event."""
    frame = frame_of_record(record)
    if record[_KIND_AT]:
        raise BadFrame("a cyclic list sends frames: this record is an event's")
    return frame


def _fifo(session: Session, number: int, role: str) -> Answer:
    pipe = session.world.pipes.open(number, role)
    handle = session.hold(HeldPipe(pipe, role))
    return m.FifoOpened(handle, pipe.id, pipe.capacity, pipe.element_size), pipe.descriptors()


def _control(session: Session, handle: int) -> CanLine:
    """The CAN line that this control is of; raises Unsupported for a LIN line's."""
    slot = session.look_up(handle, HeldControl).slot
    if not isinstance(slot, Slot):
        raise Unsupported(f"{slot.name} is a LIN line: it has no bit timing, filters and detection")
    return slot.can


def _commanded(session: Session, handle: int) -> CanLine | LinLine:
    """The line of either kind that this control is of."""
    slot = session.look_up(handle, HeldControl).slot
    return slot.lin if isinstance(slot, LinSlot) else _control(session, handle)


def _filter(session: Session, handle: int, extended: bool, *, change: bool = False) -> FormatFilter:
    """The filter of a control's line or of a channel; to `change` it, they must not be at work."""
    held = session.look_up(handle, object)
    if isinstance(held, HeldChannel):
        if change:
            held.check_inactive()
        return held.format_filter(extended)
    can = _control(session, handle)
    if change and can.running:
        raise WrongState(f"{can.line.name}: stop the line to change its filter")
    return can.format_filter(extended)


def _run_on(timeline: Timeline) -> None:
    """Until somebody's event is signalled; raises HubError where that will never be."""
    while (due_ns := timeline.next_ns()) < NEVER:
        if not timeline.run_until(due_ns):
            return
    raise HubError("this would never end: nothing is left to happen on the buses of this hub")


def _later(begin: Callable[[Callable[[int | CanwireError], None]], None], *, numbered: bool) -> Deferred:
    """An answer once what `begin` starts is done."""
    deferred = Deferred()

    def done(result: int | CanwireError) -> None:
        if isinstance(result, CanwireError):
            deferred.settle(result)
        else:
            deferred.settle((m.Number(result), ()) if numbered else DONE)

    begin(done)
    return deferred
