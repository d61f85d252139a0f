"""A message to a hub on another machine, which refuses what was under way for too long and then sends nothing back."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import HubError
from canwire.candrv.constants import Win32Error
from canwire.candrv.errors import CandrvError

if TYPE_CHECKING:
    from canwire import HubChannel
    from canwire.candrv.handle.receiving import Receiver, Ticket

LOOK_S = 1.0


def until_known(
    ticket: Ticket,
    receiver: Receiver,
    at_hub: HubChannel,
    until: Callable[[Callable[[], bool], float | None], bool],
    look: Callable[[], object],
) -> None:
    """Wait without a time limit until it is known what became of the message; the caller holds the lock.

    `until` waits for a condition, `look` takes in what has come. Calls follow all that was sent before. So a message
    that is not pending at the hub, and of which nothing has come, was refused: raises ERROR_OPERATION_ABORTED. Raises
    what ended the channel.
    """
    while not until(lambda: ticket.done, LOOK_S):
        with suppress(HubError):  # the network is cut; once the hub is lost, `until` raises
            if at_hub.status().pending:
                continue
            look()
            if not ticket.done:
                receiver.tickets.clear()
                raise CandrvError(
                    Win32Error.ERROR_OPERATION_ABORTED,
                    "the message was under way to the hub for too long, and is not sent",
                )
