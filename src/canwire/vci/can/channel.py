"""ICanChannel and ICanChannel2: the queues of one program on a line.

Source: VCI V4 manual 5.2.2, 6.6.5 and 6.6.6; rulings.md 6 and 12.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, ClassVar, Self, TypeVar
from uuid import UUID

from canwire import ChannelMode, FilterMode, Siblings
from canwire.vci.arguments import UINT8, UINT16, UINT32, within
from canwire.vci.bus_line import KIN, BusLine
from canwire.vci.can.control import CanControl2
from canwire.vci.can.filters import FilterModes
from canwire.vci.can.line import line_status, line_status2
from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.can.structures import CanChanStatus, CanChanStatus2
from canwire.vci.fifo.elements import CAN_MSG2S, CAN_MSGS, CLASSIC_CAN_MSG2S
from canwire.vci.fifo.fifo import FifoWriter
from canwire.vci.fifo.size import whole_pages
from canwire.vci.line_objects import QueueObject, fifo_load
from canwire.vci.structures.constants import (
    CAN_FEATURE_EXTDATA,
    CAN_FEATURE_FASTDATA,
    CAN_FILTER_EXCL,
    CAN_FILTER_LOCK,
    CAN_FILTER_SRRA,
    CAN_MSGTYPE_ERROR,
    CAN_MSGTYPE_INFO,
    CAN_MSGTYPE_STATUS,
    CAN_MSGTYPE_TIMEOVR,
)
from canwire.vci.structures.errors import (
    VCI_E_INVALID_STATE,
    VCI_E_INVALIDARG,
    VciError,
)
from canwire.vci.structures.guids import IID_ICanChannel, IID_ICanChannel2, IID_IFifoWriter, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    from canwire import Filtered, HubChannel

T = TypeVar("T", CanMsg, CanMsg2)
_EVENTS = (CAN_MSGTYPE_INFO, CAN_MSGTYPE_ERROR, CAN_MSGTYPE_STATUS, CAN_MSGTYPE_TIMEOVR)


class _Channel(QueueObject[T]):
    _lease: HubChannel
    _sends = False  # whether it has a transmit FIFO

    @classmethod
    def open(cls, line: BusLine, *, exclusive: bool) -> Self:
        """Open a channel; the socket calls this."""
        lease = line.open_channel(exclusive=exclusive)
        return cls(line.share(), lease)

    @vci_call
    def get_writer(self) -> FifoWriter[T]:
        """GetWriter: the writing end of the transmit FIFO.

        Raises VciNotInitialized before `initialize`, VciAccessDenied while the writer is open, VciInvalidState for a
        channel that was initialised without a transmit FIFO.
        """
        self._check_free("writer")
        if not self._sends:
            raise VciError.of(VCI_E_INVALID_STATE, f"{self._lease.name} has no transmit FIFO")
        end = self._lease.writing
        sibling = self._siblings(end, IID_IFifoWriter, self.get_writer)
        writer = FifoWriter(end, self._form, partial(self._give_back, "writer"), sibling)
        writer.obstacle = self._line.obstacle
        self._ends["writer"] = writer
        return writer

    def _set_up(self, mode: ChannelMode) -> None:
        self._lease.set_up(mode)
        self._made_anew()
        self._sends = mode.transmit > 0

    def _loads(self) -> tuple[bool, bool, int, int]:
        """The part of a channel's status after the line's status, in both kinds."""
        return *self._state(), fifo_load(self._lease.writing) if self._sends else 0


class CanChannel(_Channel[CanMsg]):
    """ICanChannel: messages of up to 8 bytes (CanMsg), without a separate filter.

    It receives messages that pass the line's filters, and each message that any channel of the line sent with srr, in
    which srr is then set. Source: manual 6.6.5.
    """

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanChannel})
    _form = CAN_MSGS

    @vci_call
    def initialize(self, rx_fifo_size: int, tx_fifo_size: int) -> None:
        """Initialize: make the FIFOs; the channel is inactive afterwards.

        The sizes are least numbers of messages, `rx_fifo_size` 1 to 65535, `tx_fifo_size` 0 to 65535, where 0 makes no
        transmit FIFO; both are rounded up to whole pages of memory. A further call makes new FIFOs: the old messages
        are lost, and readers and writers of the old FIFOs can no longer be used. Raises VciInvalidArgument.
        """
        within("rx_fifo_size", rx_fifo_size, 1, UINT16)
        within("tx_fifo_size", tx_fifo_size, 0, UINT16)
        mode = _mode(rx_fifo_size, tx_fifo_size, CanMsg.SIZE, FilterMode.PASS, 0, Siblings.ALL)
        self._set_up(mode)

    @vci_call
    def get_status(self) -> CanChanStatus:
        """GetStatus: state of channel and line, at any time; `rx_overrun` stays until `initialize`."""
        return CanChanStatus(line_status(self._line.status()), *self._loads())


class CanChannel2(_Channel[CanMsg2], FilterModes):
    """ICanChannel2: messages of up to 64 bytes (CanMsg2), with a separate filter after the line's.

    It receives its own messages sent with srr: srr is set in them, and they bypass the filter. With CAN_FILTER_SRRA it
    also receives those of other channels of the line, if they pass the filter; srr is not set in them. On a controller
    without CAN FD its writer raises VciNotSupported for messages with edl or fdr. Filter calls raise VciNotInitialized
    before `initialize`.
    Source: manual 6.6.6.
    """

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanChannel2})
    _form = CAN_MSG2S

    def __init__(self, line: BusLine, lease: HubChannel) -> None:
        super().__init__(line, lease)
        if not line.capabilities.features & (CAN_FEATURE_EXTDATA | CAN_FEATURE_FASTDATA):
            self._form = CLASSIC_CAN_MSG2S

    @vci_call
    def initialize(
        self, rx_fifo_size: int, tx_fifo_size: int, filter_size: int = 0, filter_mode: int = FilterMode.PASS
    ) -> None:
        """Initialize: make the FIFOs and the filters; the channel is inactive afterwards.

        The sizes are least numbers of messages, `rx_fifo_size` from 1, `tx_fifo_size` from 0, where 0 makes no transmit
        FIFO; both are rounded up to whole pages. `filter_size` is the number of identifiers in the 29-bit list, 0 for
        no lists; `filter_mode` is a CAN_FILTER_ mode for both filters, optionally with CAN_FILTER_SRRA. A further call
        has the same effect as with ICanChannel. Raises VciInvalidArgument.
        """
        within("rx_fifo_size", rx_fifo_size, 1, UINT32)
        within("tx_fifo_size", tx_fifo_size, 0, UINT32)
        within("filter_size", filter_size, 0, UINT32)
        plain = within("filter_mode", filter_mode, 0, UINT8) & ~CAN_FILTER_SRRA
        if not CAN_FILTER_LOCK <= plain <= CAN_FILTER_EXCL:
            raise VciError.of(VCI_E_INVALIDARG, f"filter_mode {filter_mode:#04x}: not a CAN_FILTER_ mode")
        siblings = Siblings.AS_BUS if filter_mode & CAN_FILTER_SRRA else Siblings.OWN
        mode = _mode(rx_fifo_size, tx_fifo_size, CanMsg2.SIZE, FilterMode(plain), filter_size, siblings)
        self._set_up(mode)

    @vci_call
    def get_status(self) -> CanChanStatus2:
        """GetStatus: state of channel and line, at any time; `rx_overrun` stays until `initialize`."""
        return CanChanStatus2(line_status2(self._line.status()), *self._loads())

    @vci_call
    def get_control(self) -> CanControl2:
        """GetControl: the control unit of the channel's line; raises VciAccessDenied while a program has it."""
        return CanControl2.open(self._line)

    def _filters(self) -> Filtered:
        self._check_initialized()
        return self._lease


def _mode(
    receive: int, transmit: int, size: int, filter_mode: FilterMode, filter_size: int, siblings: Siblings
) -> ChannelMode:
    return ChannelMode(
        receive=whole_pages(receive, size),
        transmit=whole_pages(transmit, size) if transmit else 0,
        exact=True,
        ticks=True,
        filter_mode=filter_mode,
        filter_size=filter_size,
        siblings=siblings,
        events=_EVENTS,
        fd=size == CanMsg2.SIZE,
        kin=KIN,
    )
