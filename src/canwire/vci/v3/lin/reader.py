"""ILinMessageReader: the reading end of a monitor's FIFO.

Source: VCI V3 .NET manual 3.1 and 4.3.3.1; reference/vci.md section 7a.
"""

from __future__ import annotations

from canwire.vci.lin.message import LinMsg
from canwire.vci.v3.lin.message import LinMessage, received
from canwire.vci.v3.message_fifo import MessageReader


class LinMessageReader(MessageReader[LinMsg, LinMessage]):
    """ILinMessageReader: reads received messages from the monitor's receive FIFO."""

    def _received(self, raw: LinMsg, out: LinMessage | None = None) -> LinMessage:
        return received(raw, out)
