"""Receivers of an interface that is in use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.wire import Batch

    Array = numpy.ndarray


class Tap(Protocol):
    """A socket that also receives the frames passed to a line for sending."""

    def going(self, interface: Interface, frames: Array) -> None:
        """Copy the frames that are kept of these (`sent_dtype`), which were passed to the line."""


class Listener(Protocol):
    """A socket that receives from an interface."""

    def take(self, batch: Batch) -> None:
        """A batch has arrived, whose rows all listeners share: copy those that are kept."""

    def congested(self) -> bool:
        """True if a hub in fast time should wait for this reader."""

    def interface_lost(self, interface: Interface, error: int) -> None:
        """ENETDOWN: its line was stopped; ENODEV: it is gone."""
