"""The SJA1000's interrupt register and its INT pin.

Bits are PeliCAN's; BasicCAN has the lower five of them. Source: data sheet 6.3.6, 6.4.6, 6.4.7; reference/sja1000.md
section 6.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.chips.sja1000.register_map import IR_EI, IR_RI

_RI, _EI = IR_RI, IR_EI


class Interrupts:
    """Which interrupts wait to be read.

    `latched` is the interrupt register, `enabled` what may get in there. `active` is True while INT is (low on
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
        """PeliCAN's RI is no latch: messages in the FIFO, and enabled."""
        self.latched = (self.latched & ~_RI) | (self.enabled & _RI if stored else 0)

    def take(self, kept: int) -> int:
        """The register, for a read that clears all of it but the bits `kept`."""
        value = self.latched
        self.latched &= kept
        self.active = self.latched != 0
        return value

    def released(self, more: bool) -> None:
        """A message was released: RI drops, and returns if there are more; so does INT, if RI alone holds it."""
        self.latched &= ~_RI
        self.active = self.latched != 0
        if more:
            self.request(_RI)

    def reset(self) -> None:
        """What reset mode leaves: EI, if it was there."""
        self.latched &= _EI

    def settle(self) -> None:
        """Let INT follow the register."""
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
