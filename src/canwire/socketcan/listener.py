"""Receivers of an interface that is in use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.wire import Batch

    Array = numpy.ndarray


class Tap(Protocol):
    """A socket that wants to know what is given to a line, too."""

    def going(self, interface: Interface, frames: Array) -> None:
        """These, of `sent_dtype`: copy what is kept."""


class Listener(Protocol):
    """A socket that receives from an interface."""

    def take(self, batch: Batch) -> None:
        """Its rows are everybody's: copy what is kept."""

    def congested(self) -> bool:
        """A hub in fast time should wait for this reader."""

    def interface_lost(self, interface: Interface, error: int) -> None:
        """ENETDOWN: its line was stopped; ENODEV: it is gone."""
