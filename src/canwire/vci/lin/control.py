"""ILinControl: the control unit, which configures, starts and stops a LIN line and sends on it.

Source: VCI V4 manual 5.3.3 and 6.7.2; rulings.md 4.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Self
from uuid import UUID

from canwire.vci.arguments import instance
from canwire.vci.bus_line import BusLine
from canwire.vci.lin.constants import LIN_MSGTYPE_DATA, LIN_MSGTYPE_SLEEP, LIN_MSGTYPE_WAKEUP
from canwire.vci.lin.line import frame_to_respond, frame_to_send, line_status, mode_of_init
from canwire.vci.lin.message import LinMsg
from canwire.vci.lin.structures import LinInitLine, LinLineStatus
from canwire.vci.line_objects import ControlObject
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.guids import IID_ILinControl, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    import canwire


class LinControl(ControlObject):
    """ILinControl: the control unit of a LIN line. Source: manual 6.7.2."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ILinControl})
    _lease: canwire.LinControl

    @classmethod
    def open(cls, line: BusLine) -> Self:
        """Open the control unit, for the BAL; one program at a time may have it."""
        lease = line.open_lin_control()
        return cls(line.share(), lease)

    @vci_call
    def init_line(self, init: LinInitLine) -> None:
        """InitLine: reset the line and configure it as master or slave; it is stopped afterwards.

        The bit rate is LIN_BITRATE_MIN to LIN_BITRATE_MAX, or LIN_BITRATE_AUTO for a slave; otherwise it raises
        VciInvalidArgument. Raises VciNotSupported, which names the missing feature.
        """
        self._lease.initialise(mode_of_init(instance(init, LinInitLine)))

    @vci_call
    def write_message(self, send: bool, message: LinMsg) -> None:
        """WriteMessage: send a message as soon as the bus is free (`send`), or put it into the response table.

        A master sends LIN_MSGTYPE_DATA (only its header with ido), LIN_MSGTYPE_SLEEP and LIN_MSGTYPE_WAKEUP, a slave
        only LIN_MSGTYPE_WAKEUP, else VciInvalidState. The call does not wait for the end of the message: until that,
        the next call raises VciError with VCI_E_BUSY. The table accepts LIN_MSGTYPE_DATA for identifiers 0 to 63, at
        any time after `init_line`. `pid` may include the parity bits.

        Raises VciNotInitialized before `init_line`, VciInvalidState before `start_line`, VciInvalidArgument for other
        types, identifiers and lengths, and for a diagnostic frame with an enhanced checksum.
        """
        kind = instance(message, LinMsg).msg_info.type
        if not send:
            _check_is_data(kind)
            self._lease.respond(frame_to_respond(message))
        elif kind == LIN_MSGTYPE_SLEEP:
            self._lease.go_to_sleep()
        elif kind == LIN_MSGTYPE_WAKEUP:
            self._lease.wake_up()
        else:
            _check_is_data(kind)
            self._lease.send(frame_to_send(message))

    @vci_call
    def get_line_status(self) -> LinLineStatus:
        """GetLineStatus: at any time."""
        return line_status(self._line.lin_status())


def _check_is_data(kind: int) -> None:
    if kind != LIN_MSGTYPE_DATA:
        what = "LIN_MSGTYPE_DATA, _SLEEP and _WAKEUP can be sent, a response must be LIN_MSGTYPE_DATA"
        raise VciError.of(VCI_E_INVALIDARG, f"message type {kind}: {what}")
