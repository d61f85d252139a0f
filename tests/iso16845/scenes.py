"""Beginnings that many purposes share: disturbed frames, overload frames, and the frames that suit them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut
from tests.iso16845.tester import Tester

E = Spec(0x100, b"\x80")  # bit 7 of its data field is a recessive stuff bit
OTHER = Spec(0x555, b"\x12\x34")


def formats(kind: str) -> Iterator[bool]:
    """Classic, and FD where the controller knows it."""
    yield False
    if kind == "fd":
        yield True


def of_format(spec: Spec, fd: bool) -> Spec:
    return spec.but(fd=fd)


class Scene(Tester):
    """A tester with a controller in a given state, and one frame format."""

    def __init__(self, kind: str, fd: bool, *, tec: int = 0, rec: int = 0, iut: Iut | None = None) -> None:
        super().__init__(kind, iut)
        self.fd = fd
        self.e = E.but(fd=fd, esi=False)
        self.other = OTHER.but(fd=fd)
        if tec or rec:
            self.iut.preset(tec, rec)

    @property
    def mine(self) -> Spec:
        """Frame E as the controller itself sends it now: with its error state."""
        return self.e

    def disturbed(self) -> Self:
        """The tester sends frame E with the stuff bit in its data dominant; the flag is to come next."""
        bits = lay_out(self.e)
        at = stuff_bit(bits)
        self.lt(bits, change={at: "0"}, until=at)
        return self

    def disturbed_sender(self, *, passive: bool = False) -> Self:
        """The controller sends frame E, with the stuff bit in its data seen dominant."""
        bits = lay_out(self.e.but(esi=passive and self.fd))
        at = stuff_bit(bits)
        self.ask(self.e)
        self.sends(bits, change={at: "0"}, until=at, ask=False)
        return self

    def again(self, *, passive: bool = False) -> Self:
        """The controller repeats frame E, and gets it acknowledged."""
        self.sends(self.e.but(esi=passive and self.fd), ask=False)
        return self

    def overloaded(self) -> Self:
        """The tester sends a good frame, whose last EOF bit is seen dominant; the overload flag is to come next."""
        bits = lay_out(self.other)
        self.lt(bits, change={len(bits.levels) - 1: "0"})
        return self

    def overloaded_sender(self, spec: Spec | None = None) -> Self:
        """The controller sends a good frame, intermission bit 1 is dominant; the overload flag is to come next."""
        self.sends(spec or self.other)
        self.dominant(1)
        return self

    def forced(self, count: int, *bits: int) -> Self:
        """The controller drives a flag of so many bits, of which these (from 1) are seen recessive."""
        self.bits("".join("1" if k in bits else "-" for k in range(1, count + 1)), "0" * count)
        return self


def stuff_bit(bits: Bits) -> int:
    """Bit 7 of frame E's data field."""
    at = bits.index("DATA", 7)
    assert bits.stuff[at] == "dynamic"
    assert bits.levels[at] == "1"
    return at
