"""What a pool's worker does, by a name that processes of every kind import."""

from __future__ import annotations

from canwire import Frame, Lab


def number_of(number: int) -> int:
    """The number, by way of a lab in real time and one in virtual time of the worker's own."""
    with Lab(time="real") as real, Lab() as lab:
        for each in (real, lab):
            bus = each.can_bus()
            a, b = bus.node("a"), bus.node("b")
            a.send(Frame(number))
            frame = b.receive(timeout=60)
            assert frame is not None
            number = frame.id
    return number
