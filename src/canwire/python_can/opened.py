"""What a bus has at its hub: a line, a channel on it, and the objects that send and receive there."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import nullcontext, suppress
from typing import Any, NamedTuple

import can

from canwire import CanwireError, ChannelMode, EventKind, Hub, LinePlace, LineStatus, Siblings, WantedMode
from canwire.python_can.clock import clock_of
from canwire.python_can.company import Company, warn_of_conflicts
from canwire.python_can.filters import LIST_SIZE, Plan
from canwire.python_can.line import kept_up, line_again, line_of_channel
from canwire.python_can.receiver import Receiver
from canwire.python_can.sender import Sender

_STATES = (EventKind.STATE, EventKind.OVERRUN)
_ERRORS = (*_STATES, EventKind.ERROR, EventKind.ARBITRATION_LOST)


class Wish(NamedTuple):
    """What a bus needs of any hub; `errors`: error frames are received."""

    name: Any
    line: str
    wanted: WantedMode
    mode: ChannelMode
    exclusive: bool
    errors: bool


def channel_mode(
    sizes: tuple[int, int], own_messages: bool, error_frames: bool | None, *, fd: bool
) -> ChannelMode:
    """How a bus uses its channel, by the arguments of can.Bus; `sizes`: messages that wait, received and to send."""
    return ChannelMode(
        *sizes,
        siblings=Siblings.OTHERS_AND_OWN if own_messages else Siblings.OTHERS,
        events=_ERRORS if error_frames else _STATES,
        filter_size=LIST_SIZE,
        fd=fd,
        kin="python-can",
    )


class Opened:
    """All of it is opened together; `before`: by a bus that had this before its hub or board went.

    Raises CanwireError.
    """

    place: LinePlace
    status: LineStatus
    receiver: Receiver

    def __init__(self, hub: Hub, wish: Wish, before: Opened | None = None) -> None:
        self.hub = hub
        if before is None:
            self.place, started = line_of_channel(hub, wish.line, wish.wanted)
        else:
            self.place, started = line_again(hub, wish.line, wish.wanted, before.place, before.status.mode)
        with started or nullcontext():  # once there is a channel the line keeps running
            self.channel = hub.open_channel(self.place.board.id, self.place.line, exclusive=wish.exclusive)
        try:
            self.status = kept_up(hub, self.place, wish.wanted)
            warn_of_conflicts(hub, self.place.info.bus)
            self.channel.set_up(wish.mode)
            self.clock = clock_of(hub)
            self.company = Company(hub, self.place, str(wish.name))
            ready: deque[can.Message] = deque() if before is None else before.receiver.ready
            self.receiver = Receiver(
                self.channel, self.clock, wish.name, wish.errors, self.company.heard_of, ready
            )
            self.sender = Sender(self.channel, self.receiver, self.company)
        except BaseException:
            self.close()
            raise

    def filter(self, plan: Plan, keeps: Callable[[can.Message], bool] | None, *, always: bool) -> None:
        """Set the filters; what they do not sort exactly, or with `always`, is sorted by `keeps`."""
        plan.apply(self.channel)
        if always or not plan.exact:
            self.receiver.keep(keeps, exact=plan.exact)

    def begin(self) -> None:
        """Receive from now on."""
        self.receiver.begin(self.status, self.channel.activate())

    def close(self) -> None:
        """Give the channel back; a second call has no effect."""
        with suppress(CanwireError):
            self.channel.close()
