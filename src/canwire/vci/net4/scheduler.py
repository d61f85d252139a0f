"""ICanScheduler and ICanScheduler2 of Ixxat.Vci4: the list makes its messages, and each message has its own `start`.

Source: the vendor's published contract and tests of Ixxat.Vci4; VCI V4 manual 5.2.5; rulings.md 9 and 49.
"""

from __future__ import annotations

from typing import Any, ClassVar, Generic, TypeVar
from uuid import UUID

from canwire.vci.arguments import UINT16
from canwire.vci.can import scheduler as can_scheduler
from canwire.vci.net4.message import CanCyclicTXMsg, CanCyclicTXMsg2
from canwire.vci.net4.socket import CanSocket, CanSocket2
from canwire.vci.structures.constants import CAN_CTXMSG_STAT_EMPTY, CAN_MAX_CTX_MSGS
from canwire.vci.structures.errors import VCI_E_INVALID_INDEX
from canwire.vci.structures.guids import IID_ICanScheduler, IID_ICanScheduler2
from canwire.vci.v3.bus_socket import BusSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentOutOfRangeException, checked

Cyclic = TypeVar("Cyclic", CanCyclicTXMsg, CanCyclicTXMsg2)


class _Scheduler(BusSocket, Generic[Cyclic]):
    """Up to 16 messages, of which at most one is sent in a tick. One program at a time may have a line's list.

    It runs immediately, unlike V3's list, which waits for Resume.
    """

    _scheduler_iid: ClassVar[UUID]
    _kind: type[Cyclic]

    def _open_more(self) -> None:
        self._scheduler: Any = self._open(self._scheduler_iid)
        self._messages: list[Cyclic] = []
        self._sent: dict[Cyclic, tuple[int, bytes]] = {}  # index in V4's list, and the content there
        self._scheduler.resume()

    @net_call
    def add_message(self) -> Cyclic:
        """AddMessage: a new message of the list, which the program fills in and then starts.

        Raises ArgumentOutOfRangeException if the list has 16 messages.
        """
        if len(self._messages) == CAN_MAX_CTX_MSGS:
            raise ArgumentOutOfRangeException(
                VCI_E_INVALID_INDEX,
                f"the list of {self.bus_name} is full: it has {CAN_MAX_CTX_MSGS} messages",
            )
        made = self._kind(self)
        self._messages.append(made)
        return made

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
        """Reset: stop the list and remove all messages, which cannot be started again."""
        self._scheduler.reset()
        self._messages.clear()
        self._sent.clear()

    def update_status(self) -> None:
        """UpdateStatus: does nothing, since Status is always up to date."""

    @net_call
    def start(self, message: Any, repeat_count: int) -> None:
        """For its messages: put a message with its present content on V4's list, and start it."""
        count = checked("repeat_count", repeat_count, UINT16)
        if message not in self._messages:
            raise ArgumentOutOfRangeException(
                VCI_E_INVALID_INDEX,
                f"the list of {self.bus_name} was reset: make another message with AddMessage",
            )
        structure = message.structure()
        content = structure.to_bytes()
        if self._sent.get(message, (0, b""))[1] != content:
            self.remove(message)
            self._sent[message] = self._scheduler.add_message(structure), content
        self._scheduler.start_message(self._sent[message][0], count)

    @net_call
    def stop(self, message: Any) -> None:
        """For its messages: stop sending one."""
        if message in self._sent:
            self._scheduler.stop_message(self._sent[message][0])

    @net_call
    def remove(self, message: Any) -> None:
        """For its messages: free the place of one in the cycles."""
        if message in self._sent:
            self._scheduler.rem_message(self._sent.pop(message)[0])

    def state(self, message: Any) -> int:
        """For its messages: the present CAN_CTXMSG_STAT_."""
        if self._disposed or message not in self._sent:
            return CAN_CTXMSG_STAT_EMPTY
        return self._state_of(self._sent[message][0])

    @net_call
    def _state_of(self, index: int) -> int:
        return int(self._scheduler.get_status().msg_stat[index])


class CanScheduler(_Scheduler[CanCyclicTXMsg], CanSocket):
    """ICanScheduler: the cyclic list for messages of up to 8 bytes."""

    _scheduler_iid = IID_ICanScheduler
    _kind = CanCyclicTXMsg
    _scheduler: can_scheduler.CanScheduler


class CanScheduler2(_Scheduler[CanCyclicTXMsg2], CanSocket2):
    """ICanScheduler2: the cyclic list for messages of up to 64 bytes."""

    _scheduler_iid = IID_ICanScheduler2
    _kind = CanCyclicTXMsg2
    _scheduler: can_scheduler.CanScheduler2
