"""ICanScheduler: the cyclic transmit list of a line.

Source: VCI V3 .NET manual 4.2.5; reference/vci.md section 7a; rulings.md 9.
"""

from __future__ import annotations

from canwire.vci.arguments import UINT16
from canwire.vci.can import scheduler as can_scheduler
from canwire.vci.structures.constants import CAN_CTXMSG_STAT_EMPTY
from canwire.vci.structures.errors import VCI_E_INVALIDARG
from canwire.vci.structures.guids import IID_ICanScheduler
from canwire.vci.v3.can.enums import CanCyclicTXTaskStatus
from canwire.vci.v3.can.message import CanCyclicTXMsg
from canwire.vci.v3.can.socket import CanSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException, checked


class CanScheduler(CanSocket):
    """ICanScheduler: up to 16 messages, of which at most one is sent in a tick. One program at a time may have it.

    The list is stopped at first. A tick lasts CyclicMessageTimerDivisor / ClockFrequency seconds.
    """

    def _open_more(self) -> None:
        self._scheduler: can_scheduler.CanScheduler = self._open(IID_ICanScheduler)
        self._listed: list[tuple[CanCyclicTXMsg, int]] = []
        self._task = CanCyclicTXTaskStatus.STOPPED

    @net_call
    def add_message(self, message: CanCyclicTXMsg) -> None:
        """AddMessage: add a copy of a message to the list, which is idle until `start_message`.

        The sum of 1 / CycleTicks over the list must not exceed 1. Otherwise, and for a message that is on the list or
        that no line can send, it raises ArgumentException. It raises VciException for a full list and for a message
        that this line cannot send in its present configuration.
        """
        if any(one is message for one, _ in self._listed):
            raise ArgumentException(VCI_E_INVALIDARG, "the message is on the list")
        index = self._scheduler.add_message(message.structure())
        self._listed.append((message, index))

    @net_call
    def remove_message(self, message: CanCyclicTXMsg) -> None:
        """RemoveMessage: stop a message and remove it from the list; its Status is then EMPTY.

        Raises ArgumentException if the message is not on the list, as do `start_message` and `stop_message`.
        """
        index = self._index(message)
        self._scheduler.rem_message(index)
        self._listed.remove((message, index))
        message.told(CAN_CTXMSG_STAT_EMPTY)

    @net_call
    def start_message(self, message: CanCyclicTXMsg, repeat_count: int = 0) -> None:
        """StartMessage: while the list runs, send a message `repeat_count` times, 1 to 65535, or without end if 0."""
        self._scheduler.start_message(self._index(message), checked("repeat_count", repeat_count, UINT16))

    @net_call
    def stop_message(self, message: CanCyclicTXMsg) -> None:
        """StopMessage: stop sending a message."""
        self._scheduler.stop_message(self._index(message))

    @net_call
    def resume(self) -> None:
        """Resume: start the list; all messages that were started before begin in the same tick."""
        self._scheduler.resume()

    @net_call
    def suspend(self) -> None:
        """Suspend: stop all messages immediately."""
        self._scheduler.suspend()

    @net_call
    def reset(self) -> None:
        """Reset: stop the list and remove all messages; their Status is then EMPTY."""
        self._scheduler.reset()
        for message, _ in self._listed:
            message.told(CAN_CTXMSG_STAT_EMPTY)
        self._listed.clear()

    def update_status(self) -> None:
        """UpdateStatus: read the list; only this updates `task_status` and the Status of running messages.

        After `dispose` it does nothing.
        """
        if not self._disposed:
            self._update_status()

    @net_call
    def _update_status(self) -> None:
        status = self._scheduler.get_status()
        self._task = CanCyclicTXTaskStatus(status.task_stat)
        for message, index in self._listed:
            message.told(status.msg_stat[index])

    @property
    def task_status(self) -> CanCyclicTXTaskStatus:
        """Whether the list ran at the last `update_status`. The .NET interface does not have this property."""
        return self._task

    def _index(self, message: CanCyclicTXMsg) -> int:
        for one, index in self._listed:
            if one is message:
                return index
        raise ArgumentException(VCI_E_INVALIDARG, "the message is not on this list")
