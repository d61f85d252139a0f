# cython: nonecheck=False
"""The SJA1000's interrupt register and its INT pin.

Bits are PeliCAN's; BasicCAN has the lower five of them. Source: data sheet 6.3.6, 6.4.6, 6.4.7; reference/sja1000.md
section 6.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.chips.sja1000.register_map import IR_EI, IR_RI

_RI, _EI = IR_RI, IR_EI


class Interrupts:
    """The pending interrupts.

    `latched` is the interrupt register, `enabled` the bits that may be set in it. `active` is True while INT is (low on
    the pin). `handler` is called when INT becomes active; an edge that comes while it runs causes another call
    after it returns, if INT is still active then.
    """

    def __init__(self) -> None:
        self.latched = 0
        self.enabled = 0
        self.active = False
        self.handler: Callable[[], None] | None = None
        self._running = False
        self._edge = False

    def request(self, bits: int) -> None:
        """Latch an interrupt; the caller then calls `settle`."""
        self.latched |= bits & self.enabled

    def level(self, stored: bool) -> None:
        """Set PeliCAN's RI, which is no latch: it is set while messages are in the FIFO, if enabled."""
        self.latched = (self.latched & ~_RI) | (self.enabled & _RI if stored else 0)

    def take(self, kept: int) -> int:
        """Return the register and clear all its bits except `kept`."""
        value = self.latched
        self.latched &= kept
        self.active = self.latched != 0
        return value

    def released(self, more: bool) -> None:
        """Clear RI after a released message, and set it again if there are more; INT follows if only RI holds it."""
        self.latched &= ~_RI
        self.active = self.latched != 0
        if more:
            self.request(_RI)

    def reset(self) -> None:
        """Clear the register for reset mode, except EI."""
        self.latched &= _EI

    def settle(self) -> None:
        """Set INT from the register, and call the handler when it becomes active."""
        if self.latched == 0:
            self.active = False
        elif not self.active:
            self.active = True
            if self.handler is not None:
                self._edge = True
                if not self._running:
                    self._call()

    def _call(self) -> None:
        self._running = True
        try:
            while self._edge and self.active and self.handler is not None:
                self._edge = False
                self.handler()
        finally:
            self._running = False
            self._edge = False
