"""ICanChannel: a program's own FIFOs on a line.

Source: VCI V3 .NET manual (seed 002) 4.2.3; reference/vci.md section 7a.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from canwire.vci import can_channel
from canwire.vci.errors import VCI_E_NOT_INITIALIZED, VciAccessDenied, VciError
from canwire.vci.guids import IID_ICanControl
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ObjectDisposedException
from canwire.vci.v3.reader_writer import CanMessageReader, CanMessageWriter
from canwire.vci.v3.socket import CanSocket
from canwire.vci.v3.status import CanChannelStatus


class CanChannel(CanSocket):
    """ICanChannel. It is inactive, and without FIFOs until `initialize`: its calls raise ObjectDisposedException.

    It receives what the line's filters let through, and every message that a channel of the line sent with
    SelfReceptionRequest.
    """

    def _open_more(self) -> None:
        self._channel: can_channel.CanChannel
        self._exclusive: bool | None
        self._initialized = False
        self._create(False)

    @net_call
    def initialize(self, receive_fifo_size: int, transmit_fifo_size: int, exclusive: bool) -> None:
        """Initialize: make the FIFOs, for at least so many messages; the channel is inactive then.

        `receive_fifo_size` 1 to 65535, `transmit_fifo_size` 0 to 65535, where 0 makes none. An `exclusive` channel
        has to be the only one of its line, and no other can be opened beside it. May be repeated: what was in the
        FIFOs is gone then, their readers and writers are dead. Raises VciException, after which the channel is
        not initialised if `exclusive` was to change.
        """
        if bool(exclusive) != self._exclusive:
            self._reopen(bool(exclusive))
        self._channel.initialize(receive_fifo_size, transmit_fifo_size)
        self._initialized = True

    @net_call
    def activate(self) -> None:
        """Activate: from now on messages move between the FIFOs and the line, as far as that is started."""
        self._initialized_channel().activate()

    @net_call
    def deactivate(self) -> None:
        """Deactivate: no more; what is in the FIFOs stays."""
        self._initialized_channel().deactivate()

    @net_call
    def get_message_reader(self) -> CanMessageReader:
        """GetMessageReader: one at a time, until its `dispose`."""
        return CanMessageReader(self._initialized_channel().get_reader())

    @net_call
    def get_message_writer(self) -> CanMessageWriter:
        """GetMessageWriter: one at a time, until its `dispose`; none without a transmit FIFO."""
        return CanMessageWriter(self._initialized_channel().get_writer())

    @property
    @net_call
    def channel_status(self) -> CanChannelStatus:
        """ChannelStatus."""
        status = self._initialized_channel().get_status()
        return CanChannelStatus(status.activated, status.rx_overrun, status.rx_fifo_load, status.tx_fifo_load)

    def _initialized_channel(self) -> can_channel.CanChannel:
        if not self._initialized:
            raise ObjectDisposedException(
                VCI_E_NOT_INITIALIZED, f"channel on {self.bus_name}: call initialize first"
            )
        return self._channel

    def _reopen(self, exclusive: bool) -> None:
        """Another channel in place of this one, for V4 decides at its making; without success one as before."""
        before, self._exclusive = self._exclusive, None  # what it is while there is no channel at all
        self._initialized = False
        with self._settings_kept():
            self._drop(self._channel)
            try:
                self._create(exclusive)
            except VciError:
                self._create(bool(before))
                raise

    def _create(self, exclusive: bool) -> None:
        self._channel = self._hold(self._socket.create_channel(exclusive))
        self._exclusive = exclusive

    @contextlib.contextmanager
    def _settings_kept(self) -> Iterator[None]:
        """Hold the line's control unit if nobody does: a line that nothing is open on forgets its settings."""
        try:
            keeper = self._bal.open_socket(self.bus_port, IID_ICanControl)
        except VciAccessDenied:
            yield
            return
        with keeper:
            yield
