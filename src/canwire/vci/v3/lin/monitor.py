"""ILinMonitor: a program's own receive FIFO on a LIN line.

Source: VCI V3 .NET manual 4.3.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from canwire.vci.lin import monitor as lin_monitor
from canwire.vci.v3.bus_socket import QueueSocket
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.lin.reader import LinMessageReader
from canwire.vci.v3.lin.socket import LinSocket
from canwire.vci.v3.lin.status import LinMonitorStatus


class LinMonitor(QueueSocket[lin_monitor.LinMonitor], LinSocket):
    """ILinMonitor. It is inactive, and without a FIFO until `initialize`: its calls raise ObjectDisposedException.

    It receives all that the line hears, and the responses that the line itself sends, marked SenderOfResponse.
    """

    @net_call
    def initialize(self, receive_fifo_size: int, exclusive: bool) -> None:
        """Initialize: make the FIFO, for at least so many messages; the monitor is inactive then.

        `receive_fifo_size` 1 to 65535. An `exclusive` monitor has to be the only one of its line, and no other can be
        opened beside it. May be repeated: what was in the FIFO is gone then, its reader is dead. Raises VciException,
        after which the monitor is not initialised if `exclusive` was to change.
        """
        self._be_exclusive(bool(exclusive))
        self._queue.initialize(receive_fifo_size)
        self._initialized = True

    @net_call
    def get_message_reader(self) -> LinMessageReader:
        """GetMessageReader: one at a time, until its `dispose`."""
        return LinMessageReader(self._initialized_queue().get_reader())

    @property
    @net_call
    def monitor_status(self) -> LinMonitorStatus:
        """MonitorStatus."""
        return LinMonitorStatus.of(self._initialized_queue().get_status())

    def _make(self, exclusive: bool) -> lin_monitor.LinMonitor:
        return self._socket.create_monitor(exclusive)
