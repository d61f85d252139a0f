"""The behaviour of a node as a class: methods for messages, timers and bus events."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from canwire.errors import BadValue
from canwire.lab.can.bus import LabNode
from canwire.timeline import Timer
from canwire.values.checks import nanoseconds
from canwire.values.event import BusEvent
from canwire.values.frame import Frame

_HOOKS = ("on_message", "on_start", "on_event", "on_timer")
_NEVER_CALLED = frozenset(  # other libraries' names for on_message
    {"on_receive", "on_recieve", "on_received", "on_rx", "on_msg", "on_message_received", "on_frame_received"}
)


class _NoBusYet:
    """The `node` of a script before `run_on`."""

    def __get__(self, instance: object, kind: type) -> _NoBusYet:
        if instance is None:
            return self
        raise AttributeError(
            f"{kind.__name__} is on no bus yet: bus.node(name, script) puts it on one, and calls its on_start"
        )


class NodeScript:
    """Base class for the behaviour of a node: override its methods, which run in the lab's time, one at a time.

    >>> class Thermometer(NodeScript):
    ...     def on_start(self):
    ...         self.every(1.0, self.report)
    ...     def report(self):
    ...         self.send(Frame(0x100, b"\\x01\\x50"))

    `bus.node("thermometer", Thermometer())` puts it on a bus.
    """

    node: LabNode = _NoBusYet()  # type: ignore[assignment]

    def __init_subclass__(cls, **arguments: Any) -> None:
        super().__init_subclass__(**arguments)
        for name in vars(cls):
            if name.startswith("on_") and not hasattr(NodeScript, name):
                _refuse_near_name(cls.__name__, name)

    def on_start(self) -> None:
        """Called when the node has joined the bus."""

    def on_message(self, frame: Frame) -> None:
        """Called for each frame that passed the filters of the node."""

    def on_event(self, event: BusEvent) -> None:
        """Called for each error, change of state and lost arbitration."""

    def on_timer(self) -> None:
        """Called by timers of `every` and `after` without a callback."""

    @property
    def now_ns(self) -> int:
        return self.node.time.timeline.now_ns

    def send(self, frame: Frame) -> None:
        self.node.send(frame)

    def every(self, seconds: float, callback: Callable[[], None] | None = None) -> Periodic:
        """Call `callback` (or on_timer) every `seconds` seconds; `cancel` of the result ends it."""
        period_ns = nanoseconds("every", seconds)
        if seconds < 1e-9:
            raise BadValue(f"every {seconds} s: a period is at least one nanosecond")
        return Periodic(self.node, period_ns, callback or self.on_timer)

    def after(self, seconds: float, callback: Callable[[], None] | None = None) -> Timer:
        """Call `callback` (or on_timer) once, after `seconds` seconds."""
        time = self.node.time
        return time.at(time.timeline.now_ns + nanoseconds("after", seconds), callback or self.on_timer)

    def run_on(self, node: LabNode) -> None:
        """Start on this node; called by `LabBus.node`."""
        self.node = node
        take = self._take_frames
        if type(self).on_event is not NodeScript.on_event:
            take = self._take_all
            node.events()
            node.on_events(partial(node.time.soon, take))
        node.on_frames(partial(node.time.soon, take))
        self.on_start()

    def __repr__(self) -> str:
        node = getattr(self, "node", None)
        return f"<{type(self).__name__} on {'no node yet' if node is None else node.line.name}>"

    def _take_frames(self) -> None:
        self.node.each_frame(self.on_message)

    def _take_all(self) -> None:
        for event in self.node.events():
            self.on_event(event)
        self._take_frames()


def _refuse_near_name(kind: str, name: str) -> None:
    """Raise TypeError for a method whose name resembles a hook, but would never be called."""
    from difflib import get_close_matches  # only for unknown methods

    if name in _NEVER_CALLED or get_close_matches(name, _HOOKS, 1, 0.85):
        raise TypeError(
            f"{kind}.{name}: a NodeScript never calls it; received frames come to on_message(frame), "
            f"and its other methods are {', '.join(_HOOKS[1:])}"
        )


class Periodic:
    """A periodic callback, without drift."""

    def __init__(self, node: LabNode, period_ns: int, callback: Callable[[], None]) -> None:
        self._time = node.time
        self._period_ns = period_ns
        self._callback = callback
        self._next_ns = self._time.timeline.now_ns
        self._timer: Timer | None = None
        self._arm()

    def cancel(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def __repr__(self) -> str:
        return f"<every {self._period_ns} ns, {'cancelled' if self._timer is None else f'next at {self._next_ns} ns'}>"

    def _arm(self) -> None:
        self._next_ns += self._period_ns
        self._timer = self._time.at(self._next_ns, self._turn, background=True)

    def _turn(self) -> None:
        self._arm()
        self._callback()
