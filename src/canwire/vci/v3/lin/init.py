"""LinInitLine: the configuration for ILinControl.InitLine.

Source: VCI V3 .NET manual 4.3.4.1; reference/vci.md section 7a.
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire.vci.lin import structures as lin_structures
from canwire.vci.structures.errors import VCI_E_INVALIDARG
from canwire.vci.v3.errors import ArgumentException, checked
from canwire.vci.v3.lin.bitrate import LinBitrate
from canwire.vci.v3.lin.enums import LinOperatingModes

_MODES = int(LinOperatingModes.MASTER | LinOperatingModes.ERRORS)


@dataclass(slots=True)
class LinInitLine:
    """Operating mode and bit rate of a line; a new one is all zeros, as in .NET: a slave that detects the bit rate."""

    operating_mode: LinOperatingModes = LinOperatingModes.SLAVE
    bitrate: LinBitrate = LinBitrate.AUTO_RATE

    def structure(self) -> lin_structures.LinInitLine:
        """V4's structure for this configuration; raises ArgumentException for an invalid mode or bit rate."""
        if not isinstance(self.bitrate, LinBitrate):
            raise ArgumentException(VCI_E_INVALIDARG, f"bitrate {self.bitrate!r:.40}: not a LinBitrate")
        return lin_structures.LinInitLine(
            op_mode=checked("operating_mode", self.operating_mode, _MODES),
            bitrate=self.bitrate.as_uint16,
        )
