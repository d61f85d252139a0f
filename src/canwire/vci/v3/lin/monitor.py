"""ILinMonitor: the receive FIFO of one program on a LIN line.

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
    """ILinMonitor. Before `initialize` it is inactive and has no FIFO: its calls raise ObjectDisposedException.

    It receives all messages of the line; in responses that the line itself sent, SenderOfResponse is set.
    """

    @net_call
    def initialize(self, receive_fifo_size: int, exclusive: bool) -> None:
        """Initialize: make the FIFO, for at least `receive_fifo_size` messages; the monitor is inactive afterwards.

        `receive_fifo_size` is 1 to 65535. An `exclusive` monitor must be the only one of its line, and no other can be
        opened while it is open. A further call makes a new FIFO: the old messages are lost, and the old reader can no
        longer be used. Raises VciException; if `exclusive` was to change, the monitor is then not initialised.
        """
        self._be_exclusive(bool(exclusive))
        self._queue.initialize(receive_fifo_size)
        self._initialized = True

    @net_call
    def get_message_reader(self) -> LinMessageReader:
        """GetMessageReader: the reader; only one can be open at a time, until its `dispose`."""
        return LinMessageReader(self._initialized_queue().get_reader())

    @property
    @net_call
    def monitor_status(self) -> LinMonitorStatus:
        """MonitorStatus."""
        return LinMonitorStatus.of(self._initialized_queue().get_status())

    def _make(self, exclusive: bool) -> lin_monitor.LinMonitor:
        return self._socket.create_monitor(exclusive)
