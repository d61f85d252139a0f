"""ILinMonitor of Ixxat.Vci4; the rest of LIN is V3's.

Source: the vendor's published contract and tests of Ixxat.Vci4; rulings.md 49.
"""

from __future__ import annotations

from canwire.vci.v3.lin import monitor as v3


class LinMonitor(v3.LinMonitor):
    """ILinMonitor: as V3's, but it may be opened beside an exclusive one, and its Initialize is refused then."""

    _may_come_late = True
