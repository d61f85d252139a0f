"""Time stamps of the frames that a socket sends (SO_TIMESTAMPING): passed to the line, and on the bus."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from canwire.socketcan.constants import CANFD_MTU
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.base import CanSocket
from canwire.socketcan.sockets.error_queue import TX, Queued, TransmitStamps
from canwire.socketcan.wire import numpy_module, received_dtype

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.port import Port

    Array = numpy.ndarray


class StampedSocket(CanSocket):
    """`put` delivers rows of `received_dtype` to the program."""

    errors: TransmitStamps | None = None

    def put(self, rows: Array) -> None:
        raise NotImplementedError

    def stamps_changed(self) -> None:
        table = self.setting.table
        if table.stamps(self.slot).flags & TX:
            self.errors = self.errors or TransmitStamps(lambda: table.stamps(self.slot))
            self.errors.begin()
            table.watch(self.slot, True)

    def take_error(self) -> Queued:
        found = self.errors.take() if self.errors is not None else None
        if found is None:
            raise refuse(errno.EAGAIN)
        self.setting.table.count_errors(self.slot, len(self.errors or ()))
        return found

    def leaving(self, port: Port, rows: Array) -> None:
        """Note that these rows of `sent_dtype` are passed to the line."""
        if self.errors is None or not len(rows):
            return
        port.stampers[self.slot] = self._sent
        before = len(self.errors)
        now_ns = self.setting.hub.now_ns() + self.setting.epoch_ns
        self.errors.leaving([_frame_of(row, "size") for row in rows], now_ns)
        self._wake_for_errors(before)

    def _sent(self, rows: Array) -> None:
        """Note that these rows of `received_dtype` were on the bus."""
        if self.errors is None or self.deserted:
            return
        before = len(self.errors)
        for row in rows:
            self.errors.sent(_frame_of(row, "length"), int(row["stamp_ns"]))
        self._wake_for_errors(before)

    def _wake_for_errors(self, before: int) -> None:
        assert self.errors is not None
        self.setting.table.count_errors(self.slot, len(self.errors))
        if len(self.errors) > before == 0:
            row = numpy_module().zeros(1, received_dtype())
            row["error"] = errno.ENOMSG  # something to wake up for: an error of which SO_ERROR says nothing
            self.put(row)


def _frame_of(row: Array, size: str) -> bytes:
    """The struct can_frame or canfd_frame in a row; the field `size` says which of them."""
    found: bytes = row.tobytes()[-CANFD_MTU:][: int(row[size])]
    return found
