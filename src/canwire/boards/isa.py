"""The I/O space and the interrupt lines of a PC that its CAN boards use.

A machine has one `IsaBus`; boards are plugged into it under names that error messages use. This file does not know
what a board does when its ports are accessed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from canwire.errors import InUse, NoSuchBoard
from canwire.values.isa_address import PORTS, SELECT, checked_byte, checked_port, port_text

FLOATING = 0xFF
"""What a processor reads where no board answers."""


@dataclass(frozen=True, slots=True)
class IsaPlace:
    """The resources of a board: 32 addresses from `base`, and one interrupt line, shared or not.

    Sharing is a promise of both drivers to check their own board whenever the line rises ("/I:5*"); the boards
    themselves do not support it.
    """

    base: int
    irq: int
    shared_irq: bool = False

    @property
    def resources(self) -> tuple[tuple[str, str], ...]:
        """The resources for the device list: kinds and values."""
        ports = f"{port_text(self.base)}-{port_text(self.base + PORTS - 1)}"
        return ("I/O", ports), ("IRQ", f"{self.irq}{'*' if self.shared_irq else ''}")


def base_conflict(one: IsaPlace, other: IsaPlace) -> bool:
    """Whether both boards would answer at the same ports."""
    return one.base == other.base


def irq_conflict(one: IsaPlace, other: IsaPlace) -> bool:
    """Whether both boards drive one interrupt line, unless both promised to share it."""
    return one.irq == other.irq and not (one.shared_irq and other.shared_irq)


class IsaCard(Protocol):
    """The interface of a board on an ISA bus. It calls `on_irq`, if set, each time it requests an interrupt."""

    on_irq: Callable[[], None] | None

    @property
    def place(self) -> IsaPlace: ...
    @property
    def irq_pending(self) -> bool: ...
    def read_port(self, port: int) -> int: ...
    def write_port(self, port: int, value: int) -> None: ...


class IsaBus:
    """Boards by address, interrupt lines by number. No threads, no I/O."""

    def __init__(self) -> None:
        self._cards: dict[str, IsaCard] = {}
        self._at: dict[int, IsaCard] = {}
        self._handlers: dict[int, list[Callable[[], None]]] = {}

    @property
    def cards(self) -> Mapping[str, IsaCard]:
        """The boards plugged in, by name, in the order of plugging."""
        return self._cards

    def plug(self, name: str, card: IsaCard) -> None:
        """Plug a board in; raises InUse with its name and the board that has its name, address or interrupt line."""
        if name in self._cards:
            raise InUse(f"a board {name} is plugged in already")
        self.check(name, card.place)
        self._cards[name] = self._at[card.place.base] = card
        irq = card.place.irq
        card.on_irq = lambda: self._requested(irq)

    def unplug(self, name: str) -> None:
        """Remove a board; its address and interrupt line are free again. Raises NoSuchBoard."""
        card = self._cards.pop(name, None)
        if card is None:
            raise NoSuchBoard(f"no board {name!r} to unplug; plugged in: {', '.join(self._cards) or 'none'}")
        del self._at[card.place.base]
        card.on_irq = None

    def check(self, name: str, place: IsaPlace) -> None:
        """Raise InUse unless a board of that name could have this place."""
        for other, card in self._cards.items():
            if base_conflict(place, card.place):
                at = port_text(place.base)
                raise InUse(f"{name} and {other} are both at {at}; give one of them another base address")
            if irq_conflict(place, card.place):
                raise InUse(
                    f"{name} and {other} both use IRQ {place.irq}; give one of them another, "
                    f"or install both as shared ({place.irq}*)"
                )

    def read(self, port: int) -> int:
        """Read from a port (IN), 0..0xFFFF: 0xFF if no board answers; raises BadValue for another port."""
        card = self._at.get(checked_port(port) & SELECT)
        return FLOATING if card is None else card.read_port(port)

    def write(self, port: int, value: int) -> None:
        """Write to a port (OUT); ignored if no board answers.

        Raises BadValue for a port or value that does not exist.
        """
        card = self._at.get(checked_port(port) & SELECT)
        checked_byte(value, port)
        if card is not None:
            card.write_port(port, value)

    # interrupt lines

    def connect(self, irq: int, handler: Callable[[], None]) -> None:
        """Call `handler` each time a board requests this interrupt, in the order of connecting."""
        self._handlers.setdefault(irq, []).append(handler)

    def disconnect(self, irq: int, handler: Callable[[], None]) -> None:
        """Stop calling this handler; a second call does nothing."""
        handlers = self._handlers.get(irq, [])
        if handler in handlers:
            handlers.remove(handler)

    def irq_pending(self, irq: int) -> bool:
        """True while a board on this line requests an interrupt that no handler has served."""
        return any(card.place.irq == irq and card.irq_pending for card in self._cards.values())

    def _requested(self, irq: int) -> None:
        for handler in tuple(self._handlers.get(irq, ())):
            handler()
