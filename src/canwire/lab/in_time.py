"""`with in_time(hub)`: waits and clocks of the standard library use the hub's time in this thread and its children."""

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
    """Use the virtual time of a hub or a lab for waits and clocks, in this thread and the threads that it starts.

    This replaces time.sleep, the clocks of `time`, threading, queue, select, selectors, asyncio and concurrent.futures,
    also in libraries: the Notifier and cyclic tasks of python-can, can-isotp, canopen. The threads run one at a time,
    always in the same order, and time passes while all of them wait. Make buses, queues and locks inside the `with`
    block. A call in C that waits for something else (a socket, another process) blocks the other threads, unless it is
    inside `with hub.away():`.

    In real time nothing changes. Raises WrongState for a hub in fast time, for a hub in lockstep if this program does
    not take part in it, and inside the time of another hub.
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
