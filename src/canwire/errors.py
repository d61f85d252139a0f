"""Every error canwire raises.

CanwireError
├── BadValue (also ValueError)     an argument has an impossible value
│   ├── BadFrame                   a frame that no bus could carry
│   ├── BadTiming                  a bit timing that no controller could run
│   ├── BadFilter                  an acceptance filter that means nothing
│   ├── BadText                    text that is no frame, event or log line
│   ├── BadLog                     a file that is no log, or of which nothing can be read
│   ├── BadConfig                  a configuration file that no hub could run
│   ├── BadDescription             a network description (DBC, LDF and so on) that means nothing
│   └── BadSignals                 signal values that their message cannot carry
├── LineError                      the line cannot do this in its present state
│   ├── QueueFull                  the transmit queue has no room
│   ├── Busy                       the previous transmission is not complete
│   ├── NotTransmitted             a frame was discarded: single shot, abort
│   ├── BusOff                     the controller left the bus
│   ├── InUse                      another program holds it
│   │   └── NoChannel              all channels of the line are in use
│   ├── NotInitialised             it must be initialised first
│   ├── WrongState                 not possible while it is running, active or open
│   ├── Unsupported                this board does not support it
│   └── NothingHeard               the bus stayed silent
├── HubError                       boards that several programs share
│   ├── HubLost                    the hub is gone
│   ├── NoSuchBoard                no board with this name or number is plugged in
│   ├── Unplugged                  the board was pulled out
│   ├── LimitReached               a limit of the client, of the hub or of the system is reached
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
    """Base class of all errors of canwire. They can be pickled and copied with their fields, text and notes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args), self.__dict__ or None


class BadValue(CanwireError, ValueError):
    """An argument with an impossible value; the message names it and gives the reason."""


class BadFrame(BadValue):
    """A frame that no bus could carry."""


class BadTiming(BadValue):
    """A bit timing that no controller could run, or a bit rate that a clock cannot produce."""


class BadFilter(BadValue):
    """An acceptance filter that means nothing."""


class BadText(BadValue):
    """Text that is no frame, event or log line."""


class BadLog(BadValue):
    """A file that is no log, or of which nothing can be read; the message names it and its first error."""


class BadConfig(BadValue):
    """A configuration that no hub could run; the message names its file and the place in it."""


class BadDescription(BadValue):
    """A network description that does not parse, or that describes no network; the message names its file."""


class BadSignals(BadValue):
    """Values that a message cannot carry, or that it lacks; `faults` maps each signal to its fault and a remedy."""

    def __init__(self, message: str, faults: Mapping[str, str]) -> None:
        super().__init__("; ".join(f"{message}.{name}: {fault}" for name, fault in faults.items()))
        self.message = message
        self.faults = dict(faults)


class LineError(CanwireError):
    """The line cannot do this in its present state."""


class QueueFull(LineError):
    """The transmit queue has no room; nothing was queued. `why` is the reason why a real adapter does not send."""

    def __init__(self, line: str, capacity: int, why: str = "") -> None:
        told = why or "let the bus run, or ask for a larger queue"
        super().__init__(f"{line}: transmit queue full, {capacity} frames wait; {told}")
        self.line = line
        self.capacity = capacity


class Busy(LineError):
    """The transmit buffer is in use; nothing was sent. It is free after its frame and the response to that frame."""

    def __init__(self, line: str) -> None:
        super().__init__(f"{line}: what was sent before is not over; let the bus run, and try again")
        self.line = line


class NotTransmitted(LineError):
    """A frame was discarded before it was sent: single shot, abort, or the line was stopped."""

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
    """Another program holds it; the message names that program."""


class NoChannel(InUse):
    """All channels that the line can have are in use."""


class NotInitialised(LineError):
    """The line or channel must be initialised first."""


class WrongState(LineError):
    """Not possible now: the line is running, the channel is active, or an end of the FIFO is open, for example."""


class Unsupported(LineError):
    """This board does not support the operation."""


class NothingHeard(LineError):
    """No valid frame was received in time."""


class HubError(CanwireError):
    """An error of the hub, or of the connection to it."""


class HubLost(HubError):
    """The hub has ended, and all its handles are invalid; connect again and reopen boards by their hardware id."""


class NoSuchBoard(HubError, LookupError):
    """No board, line, bus or FIFO has this name or number."""


class Unplugged(HubError):
    """The board was pulled out; once it is plugged in again, open it by its hardware id."""


class LimitReached(HubError):
    """The request exceeds a limit; the message names the limit, what is in use, and how to raise the limit."""


class BadMessage(HubError):
    """Bytes that mean nothing to the hub, or to its client; the connection is closed."""


class Closed(CanwireError):
    """The object was closed before; open a new one."""

    def __init__(self, what: str) -> None:
        super().__init__(f"{what} is closed")
        self.what = what


class NotIdle(CanwireError):
    """The bus does not become idle: the same frames are repeated without success."""


class NotReceived(CanwireError, AssertionError):
    """An expected frame did not arrive in time."""


class ExtraMissing(CanwireError, ImportError):
    """An optional dependency is not installed."""

    def __init__(self, module: str, extra: str) -> None:
        super().__init__(f"{module} is not installed; run: pip install 'canwire[{extra}]'")
        self.module = module
        self.extra = extra


def _again(kind: type[CanwireError], args: tuple[Any, ...]) -> CanwireError:
    """Make an error with this text, without its `__init__`, which would format the text twice; its fields follow."""
    error: CanwireError = super(CanwireError, kind).__new__(kind, *args)
    super(CanwireError, error).__init__(*args)
    return error
