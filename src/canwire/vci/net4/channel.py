"""ICanChannel and ICanChannel2 of Ixxat.Vci4.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.2 and 6.6.6.
"""

from __future__ import annotations

from canwire.vci.can import channel as can_channel
from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.net4.message import CanMessage, CanMessage2
from canwire.vci.net4.reader_writer import CanMessageReader, CanMessageWriter
from canwire.vci.net4.socket import CanSocket, CanSocket2
from canwire.vci.v3.bus_socket import QueueSocket
from canwire.vci.v3.can.status import CanChannelStatus
from canwire.vci.v3.disposable import net_call


class CanChannel(QueueSocket[can_channel.CanChannel], CanSocket):
    """ICanChannel: the same as in V3, but its reader and writer use Ixxat.Vci4's messages.

    It can be opened, but not initialised, while an exclusive channel is open.
    """

    _may_come_late = True

    @net_call
    def initialize(self, receive_fifo_size: int, transmit_fifo_size: int, exclusive: bool) -> None:
        """Initialize: the same as in V3."""
        self._be_exclusive(bool(exclusive))
        self._queue.initialize(receive_fifo_size, transmit_fifo_size)
        self._initialized = True

    @net_call
    def get_message_reader(self) -> CanMessageReader[CanMsg, CanMessage]:
        """GetMessageReader: one at a time, until its `dispose`."""
        return CanMessageReader(self._initialized_queue().get_reader(), CanMessage)

    @net_call
    def get_message_writer(self) -> CanMessageWriter[CanMsg]:
        """GetMessageWriter: one at a time, until its `dispose`; none without a transmit FIFO."""
        return CanMessageWriter(self._initialized_queue().get_writer(), CanMsg)

    @property
    @net_call
    def channel_status(self) -> CanChannelStatus:
        """ChannelStatus."""
        status = self._initialized_queue().get_status()
        return CanChannelStatus(status.activated, status.rx_overrun, status.rx_fifo_load, status.tx_fifo_load)

    def _make(self, exclusive: bool) -> can_channel.CanChannel:
        return self._socket.create_channel(exclusive)


class CanChannel2(QueueSocket[can_channel.CanChannel2], CanSocket2):
    """ICanChannel2: messages of up to 64 bytes, with a separate filter after the line's.

    Before `initialize` it is inactive and has no FIFOs and filters: its calls raise ObjectDisposedException. It
    receives its own messages sent with SelfReceptionRequest, with PASS_SELF_RECEPTIONS also those of other channels.
    It can be opened, but not initialised, while an exclusive channel is open.
    """

    _may_come_late = True

    @net_call
    def initialize(
        self,
        receive_fifo_size: int,
        transmit_fifo_size: int,
        filter_size: int,
        filter_mode: int,
        exclusive: bool,
    ) -> None:
        """Initialize: make the FIFOs and both filters; the channel is inactive afterwards.

        `filter_size` is the number of identifiers in the 29-bit list, 0 for no lists; `filter_mode` is a
        CanFilterModes. The other parameters are the same as in ICanChannel.
        """
        self._be_exclusive(bool(exclusive))
        self._queue.initialize(receive_fifo_size, transmit_fifo_size, filter_size, int(filter_mode))
        self._initialized = True

    @net_call
    def get_message_reader(self) -> CanMessageReader[CanMsg2, CanMessage2]:
        """GetMessageReader: one at a time, until its `dispose`."""
        return CanMessageReader(self._initialized_queue().get_reader(), CanMessage2)

    @net_call
    def get_message_writer(self) -> CanMessageWriter[CanMsg2]:
        """GetMessageWriter: one at a time, until its `dispose`; none without a transmit FIFO."""
        return CanMessageWriter(self._initialized_queue().get_writer(), CanMsg2)

    @property
    @net_call
    def channel_status(self) -> CanChannelStatus:
        """ChannelStatus."""
        status = self._initialized_queue().get_status()
        return CanChannelStatus(status.activated, status.rx_overrun, status.rx_fifo_load, status.tx_fifo_load)

    @net_call
    def get_filter_mode(self, select: int) -> int:
        """GetFilterMode: the present CanFilterModes of a CanFilter."""
        return self._initialized_queue().get_filter_mode(select)

    @net_call
    def set_filter_mode(self, select: int, mode: int) -> int:
        """SetFilterMode: returns the previous mode. Filters can be changed only while the channel is inactive."""
        return self._initialized_queue().set_filter_mode(select, int(mode))

    @net_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: the same as in ICanControl, but only for this channel."""
        self._initialized_queue().set_acc_filter(select, code, mask)

    @net_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: add all identifiers that match the pattern to the list."""
        self._initialized_queue().add_filter_ids(select, code, mask)

    @net_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: remove all identifiers that match the pattern from the list."""
        self._initialized_queue().rem_filter_ids(select, code, mask)

    def _make(self, exclusive: bool) -> can_channel.CanChannel2:
        return self._socket.create_channel(exclusive)
