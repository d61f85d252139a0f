"""ICanSocket and ICanSocket2: the capabilities and the status of a line, and channels on it.

Source: VCI V4 manual 5.2.1, 6.6.1, 6.6.2, 7.3.1 and 7.3.2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar
from uuid import UUID

from canwire.vci.can.channel import CanChannel, CanChannel2
from canwire.vci.can.line import line_status, line_status2
from canwire.vci.can.structures import (
    CanBtp,
    CanCapabilities,
    CanCapabilities2,
    CanLineStatus,
    CanLineStatus2,
)
from canwire.vci.line_objects import SocketObject
from canwire.vci.structures.constants import (
    CAN_BTMODE_RAW,
    CAN_FEATURE_EXTDATA,
    CAN_FEATURE_FASTDATA,
    CAN_FEATURE_ISOFRAME,
    CAN_FEATURE_NONISOFRM,
)
from canwire.vci.structures.guids import IID_ICanSocket, IID_ICanSocket2, IID_IUnknown
from canwire.vci.unknown import vci_call

if TYPE_CHECKING:
    from canwire import Capabilities, Ticks, TimingRange

_FD_FEATURES = CAN_FEATURE_EXTDATA | CAN_FEATURE_FASTDATA | CAN_FEATURE_ISOFRAME | CAN_FEATURE_NONISOFRM


class CanSocket(SocketObject):
    """ICanSocket: properties and state of a line, and channels for CANMSG. Source: manual 6.6.1."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanSocket})

    @vci_call
    def get_capabilities(self) -> CanCapabilities:
        """GetCapabilities: without the features that need ICanSocket2; all divisors apply to `clock_freq`."""
        return capabilities_of(self._line.capabilities)

    @vci_call
    def get_line_status(self) -> CanLineStatus:
        """GetLineStatus: settings, load and state of the controller now."""
        return line_status(self._line.status())

    @vci_call
    def create_channel(self, exclusive: bool = False) -> CanChannel:
        """CreateChannel: a new channel, which is not initialised yet.

        An exclusive channel must be the only one of the line: raises VciAccessDenied if another channel is open, or if
        an exclusive channel is open.
        """
        return CanChannel.open(self._line, exclusive=bool(exclusive))


class CanSocket2(SocketObject):
    """ICanSocket2: properties and state of a CAN FD line, and channels for CANMSG2. Source: manual 6.6.2."""

    interfaces: ClassVar[frozenset[UUID]] = frozenset({IID_IUnknown, IID_ICanSocket2})

    @vci_call
    def get_capabilities(self) -> CanCapabilities2:
        """GetCapabilities: timing limits are raw register values; those of the fast phase are 0 without one."""
        return capabilities2_of(self._line.capabilities)

    @vci_call
    def get_line_status(self) -> CanLineStatus2:
        """GetLineStatus: settings, load and state of the controller now."""
        return line_status2(self._line.status())

    @vci_call
    def create_channel(self, exclusive: bool = False) -> CanChannel2:
        """CreateChannel: the same as in ICanSocket."""
        return CanChannel2.open(self._line, exclusive=bool(exclusive))


def capabilities_of(capabilities: Capabilities) -> CanCapabilities:
    """CANCAPABILITIES, with one clock for all counters: the clock of the time stamps."""
    clock_hz = capabilities.stamps.clock_hz or capabilities.clock_hz
    return CanCapabilities(
        ctrl_type=capabilities.controller_type,
        bus_coupling=capabilities.bus_coupling,
        features=capabilities.features & ~_FD_FEATURES,
        clock_freq=clock_hz,
        tsc_divisor=_divisor(capabilities.stamps, clock_hz),
        cms_divisor=_divisor(capabilities.cyclic, clock_hz),
        cms_max_ticks=capabilities.cyclic.maximum,
        dtx_divisor=_divisor(capabilities.delay, clock_hz),
        dtx_max_ticks=capabilities.delay.maximum,
    )


def capabilities2_of(capabilities: Capabilities) -> CanCapabilities2:
    """CANCAPABILITIES2."""
    return CanCapabilities2(
        ctrl_type=capabilities.controller_type,
        bus_coupling=capabilities.bus_coupling,
        features=capabilities.features,
        can_clk_freq=capabilities.clock_hz,
        sdr_range_min=_bound(capabilities.nominal, 0),
        sdr_range_max=_bound(capabilities.nominal, 1),
        fdr_range_min=_bound(capabilities.data, 0),
        fdr_range_max=_bound(capabilities.data, 1),
        tsc_clk_freq=capabilities.stamps.clock_hz,
        tsc_divisor=capabilities.stamps.divisor,
        cms_clk_freq=capabilities.cyclic.clock_hz,
        cms_divisor=capabilities.cyclic.divisor,
        cms_max_ticks=capabilities.cyclic.maximum,
        dtx_clk_freq=capabilities.delay.clock_hz,
        dtx_divisor=capabilities.delay.divisor,
        dtx_max_ticks=capabilities.delay.maximum,
    )


def _divisor(ticks: Ticks, clock_hz: int) -> int:
    return ticks.divisor * clock_hz // ticks.clock_hz if ticks.clock_hz else 0


def _bound(ranges: TimingRange | None, which: int) -> CanBtp:
    """The lower (0) or upper (1) bound of each register."""
    if ranges is None:
        return CanBtp()
    return CanBtp(
        mode=CAN_BTMODE_RAW,
        bps=ranges.prescaler[which],
        ts1=ranges.tseg1[which],
        ts2=ranges.tseg2[which],
        sjw=ranges.sjw[which],
        tdo=ranges.offset_max * which,
    )
