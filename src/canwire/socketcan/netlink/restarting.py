"""Restarts after bus-off: by restart-ms, and by `ip link set can0 type can restart`.

Source: Linux 6.1's drivers/net/can/dev/dev.c (can_restart, can_bus_off).
"""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from canwire import CanwireError, ErrorState
from canwire.socketcan.constants import CAN_ERR_FLAG, CAN_MTU
from canwire.socketcan.echoes import NOBODY
from canwire.socketcan.wire import Batch, numpy_module, received_dtype

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import LinePlace
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.loop import Timer
    from canwire.socketcan.setting import Setting

_RESTARTED, _LENGTH = 0x100, 8  # CAN_ERR_RESTARTED, CAN_ERR_DLC


class Restarting:
    """The restarts of one interface in use; `tell` gets the error frame that reports one."""

    def __init__(
        self,
        setting: Setting,
        interface: Interface,
        place: LinePlace,
        tell: Callable[[Batch], object],
    ) -> None:
        self._setting = setting
        self._interface = interface
        self._place = place
        self._tell = tell
        self._timer: Timer | None = None

    def bus_off(self) -> None:
        """The line is bus-off: restart it after restart-ms, if that is set."""
        restart_ms = self._interface.restart_ms
        self.stop()
        if restart_ms:
            self._timer = self._setting.loop.call_in(restart_ms / 1000, self._restart)

    def ask(self) -> None:
        """Execute IFLA_CAN_RESTART; raises OSError: EBUSY if restarts are automatic, or the line is not bus-off."""
        status = self._place.status(self._setting.hub)
        if self._interface.restart_ms or ErrorState(status.state) is not ErrorState.BUS_OFF:
            raise OSError(errno.EBUSY, "")
        self._restart()

    def stop(self) -> None:
        """Stop restarting; a second call has no effect."""
        timer, self._timer = self._timer, None
        if timer is not None:
            timer.cancel()

    def _restart(self) -> None:
        setting = self._setting
        try:
            setting.hub.recover(self._place.board.id, self._place.line)
        except CanwireError as error:  # stopped, or gone, in between
            setting.say(f"{self._interface.name} is in bus-off, and was not restarted: {error}")
            return
        numpy = numpy_module()
        row = numpy.zeros(1, received_dtype())
        row["stamp_ns"] = setting.hub.now_ns() + setting.epoch_ns
        row["can_id"], row["len"], row["length"] = CAN_ERR_FLAG | _RESTARTED, _LENGTH, CAN_MTU
        row["interface"] = self._interface.index
        self._tell(Batch(lambda: row, numpy.full(1, NOBODY, "i4"), numpy.ones(1, bool)))
