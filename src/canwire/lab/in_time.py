"""`with in_time(hub)`: the standard library's waits and clocks are the hub's, for this thread and those it starts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from canwire.errors import WrongState
from canwire.threads.member import current
from canwire.threads.outset import begin, end

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub
    from canwire.lab.bench import Lab


@contextmanager
def in_time(hub: Hub | Lab) -> Iterator[None]:
    """Within it this thread, and those that it starts, wait and tell the time by a hub or a lab in virtual time.

    time.sleep and the clocks of `time`, threading, queue, select, selectors, asyncio and concurrent.futures are meant,
    whoever calls them: python-can's Notifier and its cyclic tasks, can-isotp, canopen. The threads run one at a time,
    always in the same order, and time passes while all of them wait. Make buses, queues and locks within it. Calls in
    C that wait for something else (a socket, another process) keep their thread's turn; `with hub.away():` gives it up.

    Where time is real nothing changes. Raises WrongState for a hub in fast time, for one in lockstep in whose time this
    program does not take part, and inside another hub's time.
    """
    keeper = hub.keeper()
    me = current()
    if keeper is None or (me is not None and me.company is hub.company):
        yield
        return
    if me is not None or hub.company is not None:
        raise WrongState(
            "this thread keeps another hub's time, or other threads keep this one's: leave that first"
        )
    company = begin(hub, keeper)
    try:
        yield
    finally:
        end(hub, company)
