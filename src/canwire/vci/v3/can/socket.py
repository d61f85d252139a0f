"""ICanSocket: the capabilities and the status of a line; the base of channels, control units and cyclic lists.

Source: VCI V3 .NET manual 4.2.2; reference/vci.md section 7a.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar
from uuid import UUID

from canwire.vci.structures.constants import CAN_FEATURE_EXTDATA, CAN_FEATURE_FASTDATA
from canwire.vci.structures.guids import IID_ICanSocket, IID_ICanSocket2
from canwire.vci.v3.bus_socket import BusSocket
from canwire.vci.v3.can.enums import CanBusCouplings, CanCtrlType, CanFeatures
from canwire.vci.v3.can.status import CanLineStatus
from canwire.vci.v3.disposable import net_call

if TYPE_CHECKING:
    from canwire.vci.can import socket as can_socket
    from canwire.vci.can import structures as can_structures

_SAME_IN_V4 = (CanFeatures.CAN_FD - 1) & 0xFFFF


class CanSocket(BusSocket):
    """ICanSocket. Any number of programs may have one; it cannot change the line.

    A tick of a timer lasts its divisor / `clock_frequency` seconds; the divisor is 0 if the controller lacks the timer.
    """

    _iid: ClassVar[UUID] = IID_ICanSocket
    _socket: can_socket.CanSocket

    def _capabilities(self) -> can_structures.CanCapabilities:
        return self._socket.get_capabilities()

    @property
    @net_call
    def controller_type(self) -> CanCtrlType:
        """ControllerType."""
        return CanCtrlType(self._capabilities().ctrl_type)

    @property
    @net_call
    def bus_coupling(self) -> CanBusCouplings:
        """BusCoupling."""
        return CanBusCouplings(self._capabilities().bus_coupling)

    @property
    @net_call
    def cyclic_message_timer_divisor(self) -> int:
        """CyclicMessageTimerDivisor."""
        return self._capabilities().cms_divisor

    @property
    @net_call
    def max_cyclic_message_ticks(self) -> int:
        """MaxCyclicMessageTicks: the longest cycle."""
        return self._capabilities().cms_max_ticks

    @property
    @net_call
    def delayed_tx_timer_divisor(self) -> int:
        """DelayedTXTimerDivisor."""
        return self._capabilities().dtx_divisor

    @property
    @net_call
    def max_delayed_tx_ticks(self) -> int:
        """MaxDelayedTXTicks: the longest delay."""
        return self._capabilities().dtx_max_ticks

    @property
    @net_call
    def line_status(self) -> CanLineStatus:
        """LineStatus: settings, load and state of the controller now."""
        return CanLineStatus.of(self._socket.get_line_status())

    @property
    @net_call
    def features(self) -> CanFeatures:
        """Features."""
        with self._bal.open_socket(self.bus_port, IID_ICanSocket2) as socket:
            word = socket.get_capabilities().features
        fd = word & (CAN_FEATURE_EXTDATA | CAN_FEATURE_FASTDATA)
        return CanFeatures(word & _SAME_IN_V4 | (CanFeatures.CAN_FD if fd else 0))

    @property
    def supports_std_or_ext_frames(self) -> bool:
        """SupportsStdOrExtFrames: 11-bit or 29-bit identifiers, not both at the same time."""
        return CanFeatures.STD_OR_EXT in self.features

    @property
    def supports_std_and_ext_frames(self) -> bool:
        """SupportsStdAndExtFrames: 11-bit and 29-bit identifiers at the same time."""
        return CanFeatures.STD_AND_EXT in self.features

    @property
    def supports_remote_frames(self) -> bool:
        """SupportsRemoteFrames."""
        return CanFeatures.REMOTE_FRAME in self.features

    @property
    def supports_error_frames(self) -> bool:
        """SupportsErrorFrames: CanOperatingModes.ERR_FRAME."""
        return CanFeatures.ERR_FRAME in self.features

    @property
    def supports_bus_load_computation(self) -> bool:
        """SupportsBusLoadComputation."""
        return CanFeatures.BUSLOAD in self.features

    @property
    def supports_exact_message_filter(self) -> bool:
        """SupportsExactMessageFilter: lists of identifiers."""
        return CanFeatures.ID_FILTER in self.features

    @property
    def supports_listen_only_mode(self) -> bool:
        """SupportsListenOnlyMode."""
        return CanFeatures.LIST_ONLY in self.features

    @property
    def supports_cyclic_message_scheduler(self) -> bool:
        """SupportsCyclicMessageScheduler: ICanScheduler."""
        return CanFeatures.SCHEDULER in self.features

    @property
    def supports_error_frame_generation(self) -> bool:
        """SupportsErrorFrameGeneration."""
        return CanFeatures.GEN_ERR_FRAME in self.features

    @property
    def supports_delayed_transmission(self) -> bool:
        """SupportsDelayedTransmission."""
        return CanFeatures.DELAYED_TX in self.features

    # as the manual spells them
    max_cyclic_msg_ticks = max_cyclic_message_ticks
    cyclic_message_time_divisor = cyclic_message_timer_divisor
