"""A task block that writes its state into an application's ACANTB, as the drivers did.

Source: INduCAN104 manual, "Task block", "Notification".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canwire import BadValue, Event, Frame
from canwire.acan.constants import Action, Notification
from canwire.acan.filters import Filter
from canwire.acan.messages import message_of
from canwire.acan.structures import ACANID, ACANMB, ACANMBSZ, ACANTB
from canwire.acan.task_block import TaskBlock


class MirroredBlock(TaskBlock):
    """The task block for `fields`, an ACANTB that its application filled in; raises BadValue with the field's name.

    It keeps wStatus, bREC, bTEC, bALC, bECC, wRMBOccupation, wRIndex and wWIndex of `fields` up to date, and writes
    each message into lpRMB at wWIndex.
    """

    def __init__(self, fields: ACANTB) -> None:
        self.fields = fields
        self._write = 0
        count = fields.bNId or len(fields.idTable)
        if count > len(fields.idTable):
            raise BadValue(f"bNId {count}: idTable has {len(fields.idTable)} filters")
        super().__init__(
            [_filter(one) for one in fields.idTable[:count]],
            conditions=fields.bSCFilter,
            size=fields.wRMBSize,
            notify=_notifier(fields),
        )
        fields.bNId = count
        _check_room("lpRMB", fields.lpRMB, fields.wRMBSize)

    def stored(self, frame: Frame) -> None:
        put_message(self.fields.lpRMB, self._write, message_of(frame))
        self._write = (self._write + 1) % self.size

    def changed(self) -> None:
        shown = self.fields
        shown.wStatus = int(self.status)
        shown.bREC, shown.bTEC, shown.bALC, shown.bECC = self.rec, self.tec, self.alc, self.ecc
        shown.wRMBOccupation, shown.wWIndex = self.occupation, self._write
        shown.wRIndex = (self._write - self.occupation) % self.size if self.size else 0
        if shown.on_change is not None:
            shown.on_change()

    def retrieve_into(self, buffer: Any, count: int) -> int:
        """Move up to `count` messages to `buffer` (lpBuf); returns how many. Raises BadValue if it is too small."""
        if buffer is None:
            raise BadValue("lpBuf is NULL")
        _check_room("lpBuf", buffer, count)
        frames = self.retrieve(count)
        for place, frame in enumerate(frames):
            put_message(buffer, place, message_of(frame))
        return len(frames)


def put_message(memory: Any, place: int, message: ACANMB) -> None:
    """Write the message number `place` of a list, or of a buffer of packed messages. A list that is too short grows."""
    if isinstance(memory, list):
        if place >= len(memory):
            memory.extend(ACANMB() for _ in range(place + 1 - len(memory)))
        memory[place] = message
    else:
        with memoryview(memory) as view:
            view.cast("B")[place * ACANMBSZ : (place + 1) * ACANMBSZ] = message.pack()


def _check_room(name: str, memory: Any, count: int) -> None:
    if isinstance(memory, list) or not count:
        return
    try:
        view = memoryview(memory)
    except (TypeError, ValueError) as error:
        raise BadValue(f"{name} {memory!r:.40}: a list, or a buffer: {error}") from None
    if view.readonly or not view.c_contiguous or view.nbytes < count * ACANMBSZ:
        raise BadValue(
            f"{name}: {view.nbytes} bytes, but {count} messages need {count * ACANMBSZ} writable bytes"
        )


def _filter(one: ACANID) -> Filter:
    is_channel = bool(one.bAction & (Action.CHANRCV | Action.CHANSND))
    return Filter(
        one.dwAnd,
        one.dwXor,
        Action(one.bAction),
        one.lpAddress if is_channel else None,
        one.bLength if is_channel else None,
    )


def _notifier(fields: ACANTB) -> Callable[[TaskBlock], object]:
    """The function that notifies this application, by its bNotType; raises BadValue if a field for it is unsuitable."""
    if fields.bNotType == Notification.EVENT:
        return _event(fields)
    if fields.bNotType == Notification.CALLBACK:
        call = fields.cbNotification
        if not callable(call):
            raise BadValue(f"cbNotification {call!r:.40}: TBNT_CALLBACK needs something to call")
        return lambda _: call(fields.dwRefData)
    if fields.bNotType == Notification.POSTMESSAGE:
        return _post_message(fields)
    raise BadValue(f"bNotType {fields.bNotType}: 0, 1 or 2")


def _event(fields: ACANTB) -> Callable[[TaskBlock], object]:
    """Sets hEvent and calls cbNotification with the block, if they are given; makes an hEvent if neither is."""
    if fields.hEvent is None and fields.cbNotification is None:
        fields.hEvent = Event()
    event, call = fields.hEvent, fields.cbNotification
    if event is not None and not callable(getattr(event, "set", None)):
        raise BadValue(f"hEvent {event!r:.40}: something with set()")
    if call is not None and not callable(call):
        raise BadValue(f"cbNotification {call!r:.40}: something to call")

    def tell(_: TaskBlock) -> None:
        if event is not None:
            event.set()
        if callable(call):
            call(fields)

    return tell


def _post_message(fields: ACANTB) -> Callable[[TaskBlock], object]:
    """Calls cbNotification, which is PostMessage; without it, puts its four arguments into hwnd, a queue."""
    call, window = fields.cbNotification, fields.hwnd
    if callable(call):
        return lambda _: call(window, fields.nMsg, fields.wStatus, fields.dwRefData)
    if call is None and callable(getattr(window, "put", None)):
        return lambda _: window.put((window, fields.nMsg, fields.wStatus, fields.dwRefData))
    raise BadValue("cbNotification, hwnd: TBNT_POSTMESSAGE needs PostMessage, or a queue with put()")
