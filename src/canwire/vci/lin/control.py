"""ILinControl: the one lease that sets a LIN line up, starts and stops it, and sends on it.

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
        """For the BAL: one program at a time may have it."""
        lease = line.open_lin_control()
        return cls(line.share(), lease)

    @vci_call
    def init_line(self, init: LinInitLine) -> None:
        """InitLine: reset the line and set it up as master or slave; it is stopped then.

        Raises VciInvalidArgument for another bit rate than LIN_BITRATE_MIN to LIN_BITRATE_MAX or, of a slave,
        LIN_BITRATE_AUTO, and VciNotSupported naming the feature that is missing.
        """
        self._lease.initialise(mode_of_init(instance(init, LinInitLine)))

    @vci_call
    def write_message(self, send: bool, message: LinMsg) -> None:
        """WriteMessage: put a message on the bus as soon as that is free (`send`), or into the response table.

        Sent are LIN_MSGTYPE_DATA, with ido its header alone, LIN_MSGTYPE_SLEEP and LIN_MSGTYPE_WAKEUP; by a
        slave LIN_MSGTYPE_WAKEUP alone, else VciInvalidState. It does not wait until the message is through:
        until then another raises VciError with VCI_E_BUSY. The table takes LIN_MSGTYPE_DATA for identifiers 0 to
        63, at any time once the line is initialised. `pid` may have its parity bits with it.
        Raises VciNotInitialized before `init_line`, VciInvalidState before `start_line`, VciInvalidArgument for
        other types, identifiers and lengths, and for an enhanced checksum of a diagnostic frame.
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
        what = "sent are LIN_MSGTYPE_DATA, _SLEEP and _WAKEUP, responses are LIN_MSGTYPE_DATA"
        raise VciError.of(VCI_E_INVALIDARG, f"message type {kind}: {what}")
