"""ISO 16845-1, 8.1: what a transmitter has to put on the wire."""

from __future__ import annotations

import random

from tests.iso16845.frames import FD_LENGTH, Spec, lay_out
from tests.iso16845.purposes import shows
from tests.iso16845.rows.terms import STUFF_BASE_FD
from tests.iso16845.scenes import Scene, formats
from tests.iso16845.test_receiver_frames import BASE_IDS, EXTENDED_IDS, stuffed_frames

STUFF_BASE = "078/08/01 then 7xE1; 41F/01/00; 47F/01/1F; 758/00/-; 777/01/1F; 7EF/42/- (remote)"
STUFF_EXT = "07C30F0F/188/8x3C; 07C0F0F0/181/00; 1FB80000/181/A0"
STUFF_EXT_SENT = (
    "01E38787/6AE/F8 then 47x78; 11F3C3C3/6A8/8x3C; 1079C1E1/6BE/48x1E; 083DF0F0/69F/64x0F; "
    "041EF878/68F/64x87; 1F0C3C3C/683/3xC3; 0F861E1E/6A3/3xE1; 07C30F0F/6A1/F0; 1FFC0000/6A0/-; 0003FFFF/6B0/-"
)


def any_length(kind: str, ids: tuple[int, ...], *, extended: bool) -> None:
    for fd in formats(kind):
        for id in ids:
            for length in FD_LENGTH[: 16 if fd else 9]:
                data = random.Random(f"{id} {length}").randbytes(length)
                spec = Spec(id, data, extended=extended, fd=fd)
                Scene(kind, fd).sends(spec).recessive(3).counters(0, 0).play(received=[])


@shows("8.1.1")
def test_base_frames_of_any_length(kind: str) -> None:
    any_length(kind, BASE_IDS, extended=False)


@shows("8.1.2")
def test_extended_frames_of_any_length(kind: str) -> None:
    any_length(kind, EXTENDED_IDS, extended=True)


def lose_at(kind: str, mine: Spec, winner: Spec, bit: int, level: str = "1") -> None:
    """The controller drives recessive there, the tester dominant; it receives, and repeats its own frame."""
    own, theirs = lay_out(mine), lay_out(winner)
    assert own.levels[:bit] == theirs.levels[:bit]
    assert (own.levels[bit], theirs.levels[bit]) == (level, "0")
    scene = Scene(kind, mine.fd)
    scene.ask(mine).lt(theirs, drives=own.levels[: bit + 1]).recessive(3).sends(mine, ask=False)
    scene.counters(0, 0).play(received=[winner])


def lose_everywhere(kind: str, mine: Spec, names: tuple[str, ...]) -> int:
    """At every recessive bit of its identifier that is no stuff bit."""
    own = lay_out(mine)
    places = [
        k for k, name in enumerate(own.names) if name in names and own.levels[k] == "1" and not own.stuff[k]
    ]
    width = 29 if mine.extended else 11
    for at in places:
        number = sum(1 for k in range(at) if own.names[k] in names and not own.stuff[k])
        winner = mine.but(id=mine.id & ~(1 << width - 1 - number), data=b"\x55")
        lose_at(kind, mine, winner, at)
    return len(places)


@shows("8.1.3")
def test_arbitration_lost_at_every_bit_of_base_frames(kind: str) -> None:
    for fd in formats(kind):
        assert lose_everywhere(kind, Spec(0x7EF, fd=fd), ("ID",)) == 10
        assert lose_everywhere(kind, Spec(0x010, fd=fd), ("ID",)) == 1


@shows("8.1.4")
def test_arbitration_lost_at_every_bit_of_extended_frames(kind: str) -> None:
    for fd in formats(kind):
        assert lose_everywhere(kind, Spec(0x1FBFFFFF, extended=True, fd=fd), ("ID", "EXT")) == 28
        mine = Spec(0x00400000, extended=True, fd=fd)
        assert lose_everywhere(kind, mine, ("ID", "EXT")) == 1
        own = lay_out(mine)
        srr = Spec(mine.id, b"\x55", extended=True, fd=fd, reserved=(("SRR", "0"),))
        lose_at(kind, mine, srr, own.plain("SRR"))
        lose_at(kind, mine, Spec(mine.id >> 18, b"\x55", fd=fd), own.plain("SRR"))
        ide = Spec(mine.id >> 18, remote=True)
        if fd:
            ide = Spec(mine.id >> 18, fd=True, reserved=(("RRS", "1"),))
        lose_at(kind, mine, ide, own.plain("IDE"))


@shows("8.1.5")
def test_valid_at_the_end_of_the_eof(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).overloaded_sender().flag().between()
        scene.counters(0, 0).play(received=[], settling=15)


def all_stuffed(kind: str, classic: str, flexible: str, *, extended: bool) -> list[Spec]:
    specs = stuffed_frames(classic, extended=extended, fd=False)
    if kind == "fd":
        specs += stuffed_frames(flexible, extended=extended, fd=True)
    return [spec.but(reserved=()) for spec in specs]


def stuffing(kind: str, specs: list[Spec]) -> None:
    for spec in specs:
        bits = lay_out(spec)
        assert bits.stuffs()
        scene = Scene(kind, spec.fd, tec=200 if spec.esi else 0)
        scene.ask(spec.but(esi=False)).sends(bits, ask=False).play(received=[])


@shows("8.1.6")
def test_stuff_bits_of_base_frames(kind: str) -> None:
    flexible = STUFF_BASE_FD.replace("107/28F", "107/08F")
    stuffing(kind, all_stuffed(kind, STUFF_BASE, flexible, extended=False))


@shows("8.1.7")
def test_stuff_bits_of_extended_frames(kind: str) -> None:
    stuffing(kind, all_stuffed(kind, STUFF_EXT, STUFF_EXT_SENT, extended=True))


JOINING_IDS = (
    0x07B,
    0x03B,
    0x7DF,
)  # 4 leading dominant bits; 5, and with the foreign SOF a stuff bit; 5 recessive ones


@shows("8.1.8")
def test_foreign_sof_in_the_third_intermission_bit(kind: str) -> None:
    for fd in formats(kind):
        for id in JOINING_IDS:
            mine, theirs = Spec(id, b"\x12", fd=fd), Spec(id - 1, b"\x34", fd=fd)
            own, winner = lay_out(mine), lay_out(theirs)
            lost = next(k for k in range(20) if own.levels[k] != winner.levels[k])
            scene = Scene(kind, fd)
            scene.ask(mine).lt(winner, drives=own.levels[: lost + 1]).recessive(2)
            joins(scene, mine).play(received=[theirs])


def joins(scene: Scene, mine: Spec) -> Scene:
    """A dominant bit that the controller takes for its SOF; the rest of its frame follows."""
    scene.dominant(1)
    scene.sends(mine, since=1, ask=False)
    return scene
