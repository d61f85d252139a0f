"""Who hears an interface that is in use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.wire import Batch


class Listener(Protocol):
    """A socket that hears an interface."""

    def take(self, batch: Batch) -> None:
        """Its rows are everybody's: copy what is kept."""

    def congested(self) -> bool:
        """A hub in fast time should wait for whoever reads there."""

    def interface_lost(self, interface: Interface, error: int) -> None:
        """ENETDOWN: its line was stopped; ENODEV: it is gone."""
