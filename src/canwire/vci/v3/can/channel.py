"""ICanChannel: the FIFOs of one program on a line.

Source: VCI V3 .NET manual 4.2.3; reference/vci.md section 7a.
"""

from __future__ import annotations

from canwire.vci.can import channel as can_channel
from canwire.vci.v3.bus_socket import QueueSocket
from canwire.vci.v3.can.reader_writer import CanMessageReader, CanMessageWriter
from canwire.vci.v3.can.socket import CanSocket
from canwire.vci.v3.can.status import CanChannelStatus
from canwire.vci.v3.disposable import net_call


class CanChannel(QueueSocket[can_channel.CanChannel], CanSocket):
    """ICanChannel. Before `initialize` it is inactive and has no FIFOs: its calls raise ObjectDisposedException.

    It receives messages that pass the line's filters, and each message that a channel of the line sent with
    SelfReceptionRequest.
    """

    @net_call
    def initialize(self, receive_fifo_size: int, transmit_fifo_size: int, exclusive: bool) -> None:
        """Initialize: make the FIFOs; the channel is inactive afterwards.

        The sizes are least numbers of messages: `receive_fifo_size` 1 to 65535, `transmit_fifo_size` 0 to 65535, where
        0 makes no transmit FIFO. An `exclusive` channel must be the only one of its line, and no other can be opened
        while it is open. A further call makes new FIFOs: the old messages are lost, and readers and writers of the old
        FIFOs can no longer be used. Raises VciException; if `exclusive` was to change, the channel is then not
        initialised.
        """
        self._be_exclusive(bool(exclusive))
        self._queue.initialize(receive_fifo_size, transmit_fifo_size)
        self._initialized = True

    @net_call
    def get_message_reader(self) -> CanMessageReader:
        """GetMessageReader: the reader; only one can be open at a time, until its `dispose`."""
        return CanMessageReader(self._initialized_queue().get_reader())

    @net_call
    def get_message_writer(self) -> CanMessageWriter:
        """GetMessageWriter: the writer; only one can be open at a time, and none without a transmit FIFO."""
        return CanMessageWriter(self._initialized_queue().get_writer())

    @property
    @net_call
    def channel_status(self) -> CanChannelStatus:
        """ChannelStatus."""
        status = self._initialized_queue().get_status()
        return CanChannelStatus(status.activated, status.rx_overrun, status.rx_fifo_load, status.tx_fifo_load)

    def _make(self, exclusive: bool) -> can_channel.CanChannel:
        return self._socket.create_channel(exclusive)
