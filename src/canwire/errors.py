"""Every error canwire raises.

CanwireError
├── BadValue (also ValueError)     the caller handed in something impossible
│   ├── BadFrame                   a frame that no bus could carry
│   ├── BadTiming                  a bit timing that no controller could run
│   ├── BadFilter                  an acceptance filter that means nothing
│   ├── BadText                    text that is no frame, event or log line
│   ├── BadLog                     a file that is no log, or of which nothing can be read
│   ├── BadConfig                  a configuration file that no hub could run
│   ├── BadDescription             a network description (DBC, LDF and so on) that means nothing
│   └── BadSignals                 signal values that their message cannot carry
├── LineError                      a line cannot do that now
│   ├── QueueFull                  the transmit queue has no room
│   ├── Busy                       what was sent before is not over
│   ├── NotTransmitted             a frame was given up: single shot, abort
│   ├── BusOff                     the controller left the bus
│   ├── InUse                      somebody else holds it
│   │   └── NoChannel              all channels of the line are taken
│   ├── NotInitialised             it must be initialised first
│   ├── WrongState                 not while it is running, active or open
│   ├── Unsupported                this board cannot do that
│   └── NothingHeard               the bus stayed silent
├── HubError                       boards that several programs share
│   ├── HubLost                    the hub is gone
│   ├── NoSuchBoard                no board by that name or number is plugged in
│   ├── Unplugged                  the board was pulled out
│   ├── LimitReached               a client has as much as one may have, or the hub as much as the system gives
│   └── BadMessage                 bytes that mean nothing to the hub, or its client
├── Closed                         the object was closed before
├── NotIdle                        the bus never came to rest
├── NotReceived                    an expected frame did not arrive
└── ExtraMissing (also ImportError)   an optional dependency is not installed
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class CanwireError(Exception):
    """Root of the tree above. Every one can be pickled and copied, with its fields, its text and its notes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args), self.__dict__ or None


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


class BadLog(BadValue):
    """A file that is no log, or of which nothing can be read; the message names it and the first thing wrong."""


class BadConfig(BadValue):
    """A configuration that no hub could run; the message names its file and the place in it."""


class BadDescription(BadValue):
    """A network description that does not parse, or that describes no network; the message names its file."""


class BadSignals(BadValue):
    """Values that a message cannot carry, or that it lacks; `faults` says by signal what is wrong and what would do."""

    def __init__(self, message: str, faults: Mapping[str, str]) -> None:
        super().__init__("; ".join(f"{message}.{name}: {fault}" for name, fault in faults.items()))
        self.message = message
        self.faults = dict(faults)


class LineError(CanwireError):
    """A line cannot do what was asked of it now."""


class QueueFull(LineError):
    """The transmit queue has no room; nothing was queued. `why` is what keeps a real adapter off its bus."""

    def __init__(self, line: str, capacity: int, why: str = "") -> None:
        told = why or "let the bus run, or ask for a larger queue"
        super().__init__(f"{line}: transmit queue full, {capacity} frames wait; {told}")
        self.line = line
        self.capacity = capacity


class Busy(LineError):
    """The transmit buffer is taken; nothing was sent. It is free once the frame in it, and its response, are over."""

    def __init__(self, line: str) -> None:
        super().__init__(f"{line}: what was sent before is not over; let the bus run, and try again")
        self.line = line


class NotTransmitted(LineError):
    """A frame was given up before it got through: single shot, abort, or the line was stopped."""

    def __init__(self, line: str, frame: object, why: str) -> None:
        super().__init__(f"{line}: {frame} was not transmitted: {why}")
        self.line = line
        self.frame = frame
        self.why = why


class BusOff(LineError):
    """The controller left the bus: its transmit error counter passed 255.

    Nothing is sent or received until the line is restarted.
    Source: ISO 11898-1, fault confinement.
    """

    def __init__(self, line: str) -> None:
        super().__init__(f"{line}: bus-off; restart it to rejoin the bus")
        self.line = line


class InUse(LineError):
    """Somebody else holds it; the message says who."""


class NoChannel(InUse):
    """A line has so many channels, and all of them are taken."""


class NotInitialised(LineError):
    """The line or channel must be initialised first."""


class WrongState(LineError):
    """Not now: the line is running, the channel is active, or an end is open."""


class Unsupported(LineError):
    """This board cannot do that."""


class NothingHeard(LineError):
    """No valid frame was heard in time."""


class HubError(CanwireError):
    """Something between this program and the boards it shares."""


class HubLost(HubError):
    """The hub is gone, and with it every handle; connect again and reopen boards by their hardware id."""


class NoSuchBoard(HubError, LookupError):
    """No board, line, bus or FIFO by that name or number."""


class Unplugged(HubError):
    """The board was pulled out; replugged, it can be opened again by its hardware id."""


class LimitReached(HubError):
    """This request needs more than the hub may give: the message says which limit, what is used, how to raise it."""


class BadMessage(HubError):
    """Bytes that mean nothing to the hub, or to its client; the connection is closed."""


class Closed(CanwireError):
    """The object was closed before; open a new one."""

    def __init__(self, what: str) -> None:
        super().__init__(f"{what} is closed")
        self.what = what


class NotIdle(CanwireError):
    """The bus never came to rest: the same frames are repeated without success."""


class NotReceived(CanwireError, AssertionError):
    """An expected frame did not arrive in time."""


class ExtraMissing(CanwireError, ImportError):
    """An optional dependency is not installed."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(f"{module} is not installed; run: pip install 'canwire[{extra}]'")
        self.module = module
        self.extra = extra


def _again(kind: type[CanwireError], args: tuple[Any, ...]) -> CanwireError:
    """An error of that text without its own `__init__`, which would word the text anew; its fields come later."""
    error: CanwireError = super(CanwireError, kind).__new__(kind, *args)
    super(CanwireError, error).__init__(*args)
    return error
