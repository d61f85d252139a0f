"""The oscillator of a controller; a fault may make it slow or fast at any moment."""

from __future__ import annotations

from math import prod
from typing import Any

_CLASSIC = ("bit_ps", "sample_ps", "quantum_ps", "phase1_ps", "jump_ps", "sample_gap_ps")
_FD = (
    *_CLASSIC,
    "data_bit_ps",
    "data_sample_ps",
    "data_quantum_ps",
    "data_jump_ps",
    "second_sample_ps",
    "least_second_ps",
)


class Crystal:
    """Faults on one controller's clock; each is a factor on its frequency, 1.0 for none, and all of them multiply.

    Chips apply `oscillator_ppm` when their timing is programmed; an ideal controller's times are scaled here.
    """

    def __init__(self) -> None:
        self._factors: list[float] = []
        self._applied = 1.0
        self._true: list[int] = []  # times without any fault, and what they were made into
        self._false: list[int] = []

    @property
    def drift_ppm(self) -> float:
        """The oscillator's deviation because of faults, in ppm; positive: fast."""
        return (prod(self._factors) - 1.0) * 1e6

    def pull(self, node: Any, factor: float) -> None:
        """Add a fault."""
        self._factors.append(factor)
        self._apply(node)

    def release(self, node: Any, factor: float) -> None:
        """Remove a fault."""
        self._factors.remove(factor)
        self._apply(node)

    def configured(self, node: Any) -> None:
        """Apply the faults to new bit times of the controller; those of an ideal controller are exact at this point."""
        if self._factors and not _is_chip(node):
            self._applied, self._false = 1.0, []
            self._apply(node)

    def _apply(self, node: Any) -> None:
        factor = prod(self._factors)
        true = self._without_faults(node)
        if _is_chip(node):
            node.oscillator_ppm = (factor - 1.0) * 1e6
        self._true, self._false = true, [round(time / factor) for time in true]
        self._applied = factor
        if node.bus is not None:
            node.bus.interrupt()
        for name, time in zip(_names(node), self._false, strict=True):
            setattr(node, name, time)
        if node.bus is not None:
            node.bus.changed()

    def _without_faults(self, node: Any) -> list[int]:
        now = [getattr(node, name) for name in _names(node)]
        if self._applied == 1.0:
            return now
        if now == self._false:
            return self._true
        tick_ps = 10**12 // getattr(node, "oscillator_hz", 10**12)  # a chip's new timing: in whole ticks
        return [round(time * self._applied / tick_ps) * tick_ps for time in now]


def _is_chip(node: Any) -> bool:
    return hasattr(node, "oscillator_ppm")


def _names(node: Any) -> tuple[str, ...]:
    """The attributes of the node that its oscillator determines; chips know classic CAN only."""
    return _CLASSIC if _is_chip(node) else _FD
