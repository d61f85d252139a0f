"""The MCP2515's registers as bytes, and its INT pin. Source: DS20001801 chapter 7."""

from __future__ import annotations

from collections.abc import Callable

from canwire.bus.can.node import Node
from canwire.chips.mcp2515 import register_map as m

_CANINTE, _CANINTF = m.CANINTE, m.CANINTF


class InterruptPin(Node):
    """INT, active (`interrupt`; low on the pin) while an enabled flag is set.

    `cells` are the chip's 128 bytes, but for CANSTAT, TEC and REC. `on_interrupt` is called when INT becomes
    active; an edge that comes while it runs causes another call after it returns, if INT is still active then.
    """

    def __init__(self) -> None:
        super().__init__()
        self.cells = bytearray(m.ADDRESSES)
        self.interrupt = False
        self.on_interrupt: Callable[[], None] | None = None
        self._handling = self._edge = False

    def _signal(self) -> None:
        """Set INT from the flags, and call the handler when it becomes active."""
        if not self.cells[_CANINTF] & self.cells[_CANINTE]:
            self.interrupt = False
        elif not self.interrupt:
            self.interrupt = True
            if self.on_interrupt is not None:
                self._edge = True
                if not self._handling:
                    self._handle()

    def _handle(self) -> None:
        self._handling = True
        try:
            while self._edge and self.interrupt and self.on_interrupt is not None:
                self._edge = False
                self.on_interrupt()
        finally:
            self._handling = self._edge = False
