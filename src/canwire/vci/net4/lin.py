"""ILinMonitor of Ixxat.Vci4; all other classes of LIN are V3's.

Source: the vendor's published contract and tests of Ixxat.Vci4; rulings.md 49.
"""

from __future__ import annotations

from canwire.vci.v3.lin import monitor as v3


class LinMonitor(v3.LinMonitor):
    """ILinMonitor: the same as in V3, but it can be opened, not initialised, while an exclusive monitor is open."""

    _may_come_late = True
