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
    """ICanChannel: as V3's, whose reader and writer have Ixxat.Vci4's messages.

    It may be opened beside an exclusive one, but not initialised.
    """

    _may_come_late = True

    @net_call
    def initialize(self, receive_fifo_size: int, transmit_fifo_size: int, exclusive: bool) -> None:
        """Initialize: as V3's."""
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
    """ICanChannel2: messages of up to 64 bytes, with a filter of its own behind the line's.

    It is inactive, and without FIFOs and filters until `initialize`: its calls raise ObjectDisposedException. Of
    messages sent with SelfReceptionRequest it receives its own; with PASS_SELF_RECEPTIONS those of other channels too.
    It may be opened beside an exclusive one, but not initialised.
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
        """Initialize: make FIFOs for at least so many messages, and both filters; the channel is inactive then.

        `filter_size` is how many identifiers the 29-bit list holds, 0 for no lists; `filter_mode` CanFilterModes.
        The rest as ICanChannel's.
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
        """GetFilterMode: the CanFilterModes of a CanFilter."""
        return self._initialized_queue().get_filter_mode(select)

    @net_call
    def set_filter_mode(self, select: int, mode: int) -> int:
        """SetFilterMode: returns the mode before. Like the next three only while the channel is inactive."""
        return self._initialized_queue().set_filter_mode(select, int(mode))

    @net_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: as ICanControl's, for this channel alone."""
        self._initialized_queue().set_acc_filter(select, code, mask)

    @net_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: put all that agrees with the pattern on the list."""
        self._initialized_queue().add_filter_ids(select, code, mask)

    @net_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: take all that agrees with the pattern off the list."""
        self._initialized_queue().rem_filter_ids(select, code, mask)

    def _make(self, exclusive: bool) -> can_channel.CanChannel2:
        return self._socket.create_channel(exclusive)
