"""The hub's answers to requests about its time; in virtual time, these requests let time pass."""

from __future__ import annotations

from canwire.errors import HubError
from canwire.held_time import HeldTime
from canwire.hub.owner.answers.registry import Answers
from canwire.hub.owner.session import Session
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.timeline import NEVER, Timeline

_LARGEST_NS = 1 << 62
_SILENCE_NS = 3_600_000_000_000

answers = Answers()


@answers.to(m.Advance)
def _advance(request: m.Advance, session: Session, world: World) -> Answer:
    timeline = world.timeline
    if world.virtual and world.lockstep is None and request.span_ns > 0:
        timeline.at(timeline.now_ns, world.kick_all)  # as a happening, whose signals count
        end_ns = timeline.now_ns + request.span_ns
        if end_ns < _LARGEST_NS:
            world.held.run(timeline, end_ns)
        else:
            _run_on(timeline, world.held)
    return m.Number(timeline.now_ns), ()


def _run_on(timeline: Timeline, held: HeldTime) -> None:
    """Let time pass until an event is signalled; raises HubError after an hour, as boards' clocks tick without end."""
    began_ns = timeline.now_ns
    while (due_ns := timeline.next_ns()) < NEVER and due_ns <= began_ns + _SILENCE_NS:
        if not held.run(timeline, due_ns):
            return
    if due_ns >= NEVER:
        raise HubError("this would never end: no further event is due on the buses of this hub")
    raise HubError(
        f"this would never end: it waits without a timeout since {began_ns / 1e9:.9f} s, and nothing arrived for an "
        f"hour of the hub's time; if another thread is to send, run all threads in that time: with canwire.in_time(hub)"
    )
