"""ILinControl: the control unit of a LIN line.

Source: VCI V3 .NET manual 4.3.4; reference/vci.md section 7a; rulings.md 4.
"""

from __future__ import annotations

from typing import ClassVar
from uuid import UUID

from canwire.vci.lin import control as lin_control
from canwire.vci.lin import structures as lin_structures
from canwire.vci.lin.constants import LIN_BITRATE_UNDEF
from canwire.vci.structures.errors import VCI_E_INVALIDARG
from canwire.vci.structures.guids import IID_ILinControl
from canwire.vci.v3.bus_socket import ControlSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException
from canwire.vci.v3.lin.init import LinInitLine
from canwire.vci.v3.lin.message import LinMessage
from canwire.vci.v3.lin.socket import LinSocket


class LinControl(ControlSocket, LinSocket):
    """ILinControl. One program at a time may have it.

    The states of a line: undefined -> `init_line` -> offline -> `start_line` -> online -> `stop_line` or `reset_line`
    -> offline. A call that is not allowed in a state raises VciException. After `dispose` the line stays as it is while
    another interface of the line is open. After `reset_line` the line keeps a bit rate that it detected.
    """

    _control_iid: ClassVar[UUID] = IID_ILinControl
    _control: lin_control.LinControl

    @net_call
    def init_line(self, init: LinInitLine) -> None:
        """InitLine: reset the line and configure it; it is offline afterwards.

        Raises ArgumentException for a bit rate that no line has, such as LinBitrate.UNDEFINED, and VciException, which
        names the missing feature.
        """
        if not isinstance(init, LinInitLine):
            raise ArgumentException(VCI_E_INVALIDARG, f"a LinInitLine belongs here, not {init!r:.60}")
        self._control.init_line(init.structure())

    @net_call
    def write_message(self, send: bool, message: LinMessage) -> None:
        """WriteMessage: send a message as soon as the bus is free (`send`), or put it into the response table.

        A master sends LinMessageType.DATA (only its header with IdOnly), SLEEP and WAKEUP, a slave only WAKEUP. The
        call does not wait for the end of the message: until that, the next call raises VciException with VCI_E_BUSY.
        The table accepts DATA for identifiers 0 to 63, at any time after `init_line`. Raises ArgumentException for
        other types and identifiers.
        """
        if not isinstance(message, LinMessage):
            raise ArgumentException(VCI_E_INVALIDARG, f"a LinMessage belongs here, not {message!r:.60}")
        self._control.write_message(send, message.raw)

    def _settings(self) -> lin_structures.LinInitLine | None:
        status = self._control.get_line_status()
        if status.bitrate == LIN_BITRATE_UNDEF:
            return None
        return lin_structures.LinInitLine(op_mode=status.op_mode, bitrate=status.bitrate)
