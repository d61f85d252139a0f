"""Every error canwire raises.

CanwireError
├── BadValue (also ValueError)     the caller handed in something impossible
│   ├── BadFrame                   a frame that no bus could carry
│   ├── BadTiming                  a bit timing that no controller could run
│   ├── BadFilter                  an acceptance filter that means nothing
│   └── BadText                    text that is no frame, event or log line
├── LineError                      a line cannot do that now
│   ├── QueueFull                  the transmit queue has no room
│   ├── NotTransmitted             a frame was given up: single shot, abort
│   └── BusOff                     the controller left the bus
├── Closed                         the object was closed before
├── NotIdle                        the bus never came to rest
├── NotReceived                    an expected frame did not arrive
└── ExtraMissing (also ImportError)   an optional dependency is not installed
"""

from __future__ import annotations


class CanwireError(Exception):
    """Root of the tree above."""


class BadValue(CanwireError, ValueError):
    """A value from the caller that cannot be right; the message says which and why."""


class BadFrame(BadValue):
    """A frame that no bus could carry."""


class BadTiming(BadValue):
    """A bit timing that no controller could run, or a bit rate a clock cannot make."""


class BadFilter(BadValue):
    """An acceptance filter that means nothing."""


class BadText(BadValue):
    """Text that is no frame, event or log line."""


class LineError(CanwireError):
    """A line cannot do what was asked of it now."""


class QueueFull(LineError):
    """The transmit queue has no room; nothing was queued."""

    def __init__(self, line: str, capacity: int) -> None:
        super().__init__(
            f"{line}: transmit queue full, {capacity} frames wait; let the bus run, or ask for a larger queue"
        )
        self.line = line
        self.capacity = capacity


class NotTransmitted(LineError):
    """A frame was given up before it got through: single shot, abort, or the line was stopped."""

    def __init__(self, line: str, frame: object, why: str) -> None:
        super().__init__(f"{line}: {frame} was not transmitted: {why}")
        self.line = line
        self.frame = frame


class BusOff(LineError):
    """The controller left the bus: its transmit error counter passed 255.

    Nothing is sent or received until the line is restarted.
    Source: ISO 11898-1, fault confinement.
    """

    def __init__(self, line: str) -> None:
        super().__init__(f"{line}: bus-off; restart it to rejoin the bus")
        self.line = line


class Closed(CanwireError):
    """The object was closed before; open a new one."""

    def __init__(self, what: str) -> None:
        super().__init__(f"{what} is closed")


class NotIdle(CanwireError):
    """The bus never came to rest: the same frames are repeated without success."""


class NotReceived(CanwireError, AssertionError):
    """An expected frame did not arrive in time."""


class ExtraMissing(CanwireError, ImportError):
    """An optional dependency is not installed."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(f"{module} is not installed; run: pip install 'canwire[{extra}]'")
