"""ISO 16845-1, 7.1: what a receiver has to take in."""

from __future__ import annotations

import random

from canwire import BitTiming
from tests.iso16845.frames import FD_LENGTH, Bits, Spec, lay_out, pattern
from tests.iso16845.iut import NOMINAL_FD, Iut
from tests.iso16845.purposes import WHAT, shows
from tests.iso16845.rows.terms import (
    STUFF_BASE_CLASSIC,
    STUFF_BASE_FD,
    STUFF_EXT_CLASSIC,
    STUFF_EXT_FD,
)
from tests.iso16845.scenes import Scene, formats

BASE_IDS = (0x555, 0x2AA, 0x000, 0x7FF, random.Random(711).getrandbits(11))
EXTENDED_IDS = (0x15555555, 0x0AAAAAAA, 0, 0x1FFFFFFF, random.Random(712).getrandbits(29))
TWICE = BitTiming(4, 13, 6, 4, clock_hz=80_000_000)  # 20 quanta: 1 Mbit/s, half a nominal bit
EIGHT_TIMES = BitTiming(4, 3, 1, 1, clock_hz=80_000_000)  # 5 quanta: 4 Mbit/s


def any_length(kind: str, ids: tuple[int, ...], *, extended: bool) -> None:
    for fd in formats(kind):
        for id in ids:
            for length in FD_LENGTH[: 16 if fd else 9]:
                data = random.Random(f"{id} {length}").randbytes(length)
                scene = Scene(kind, fd, rec=9)
                spec = Spec(id, data, extended=extended, fd=fd)
                scene.lt(spec).recessive(3).counters(0, 8).play(received=[spec])


@shows("7.1.1")
def test_base_frames_of_any_length(kind: str) -> None:
    any_length(kind, BASE_IDS, extended=False)


@shows("7.1.2")
def test_extended_frames_of_any_length(kind: str) -> None:
    any_length(kind, EXTENDED_IDS, extended=True)


# winner, loser, and the field whose last bit decides
RIVALS = [
    (Spec(0x2A5), Spec(0x2A5, remote=True), "RTR"),
    (Spec(0x2A5), Spec(0x2A5 << 18, extended=True), "SRR"),
    (Spec(0x2A5, remote=True), Spec(0x2A5 << 18, extended=True), "IDE"),
    (Spec(0x2A4 << 18 | 0x155, extended=True), Spec(0x2A5), "ID"),
    (Spec(0x12345554, extended=True), Spec(0x12345555, extended=True), "EXT"),
    (Spec(0x12345555, extended=True), Spec(0x12345555, extended=True, remote=True), "RTR"),
]
MIXED = [
    (Spec(0x2A4), Spec(0x2A5, fd=True), "ID"),
    (Spec(0x2A5, fd=True), Spec(0x2A5, remote=True), "RTR"),
    (Spec(0x12345554, extended=True), Spec(0x12345555, extended=True, fd=True), "EXT"),
    (Spec(0x12345555, extended=True, fd=True), Spec(0x12345555, extended=True, remote=True), "RTR"),
]


@shows("7.1.3")
def test_winner_is_received_and_the_own_frame_repeated(kind: str) -> None:
    for winner, loser, field in RIVALS + (MIXED if kind == "fd" else []):
        lose_arbitration(Scene(kind, False), winner, loser, field).play(received=[winner])


def lose_arbitration(scene: Scene, winner: Spec, loser: Spec, field: str) -> Scene:
    """Both start together; the controller falls silent at the last bit of this field, and repeats its frame."""
    mine, theirs = lay_out(loser), lay_out(winner)
    differing = next(k for k in range(len(mine.levels)) if mine.levels[k] != theirs.levels[k])
    last = [k for k, name in enumerate(mine.names) if name == field and not mine.stuff[k]][-1]
    assert differing == last
    assert mine.levels[differing] == "1"
    scene.ask(loser)
    start = scene.now_ps
    scene.lt(theirs, drives=mine.levels[: differing + 1])
    assert scene.now_ps > start
    scene.recessive(3).sends(loser, ask=False)
    return scene


@shows("7.1.4")
def test_reserved_bit_of_base_frames(kind: str) -> None:
    if kind == "fd":
        spec = Spec(0x155, b"\x11\x22", fd=True, reserved=(("RRS", "1"),))
    else:
        spec = Spec(0x155, b"\x11\x22", reserved=(("FDF", "1"),))
    Scene(kind, False).lt(spec).play(received=[spec])


@shows("7.1.5")
def test_reserved_bits_of_extended_frames(kind: str) -> None:
    spec = Spec(0x15151515, b"\x11\x22", extended=True, fd=kind == "fd")
    names = {"fd": ("SRR", "RRS"), "tolerant": ("SRR", "r0")}.get(kind, ("SRR", "r0", "FDF"))
    two = ("11", "01", "00")
    values = two if len(names) == 2 else ("111", "110", "101", "011", "010", "001", "000")
    for value in values:
        sent = spec.but(reserved=tuple(zip(names, value, strict=True)))
        Scene(kind, False).lt(sent).play(received=[sent])


EXCEPTIONS = [
    (TWICE, b"\xaa" * 16),
    (EIGHT_TIMES, b"\xff" * 64),
    (EIGHT_TIMES, b"\x55" * 64),
]


def exceptional(kind: str, data: bytes) -> Bits:
    """FDF alone is enough for a controller that knows no FD frames."""
    return lay_out(Spec(0x155, data, fd=True, reserved=(("res", "1"),) if kind == "fd" else ()))


@shows("7.1.6")
def test_protocol_exception(kind: str) -> None:
    for timing, data in EXCEPTIONS:
        bits = exceptional(kind, data)
        scene = Scene(kind, False, iut=Iut(kind, NOMINAL_FD, timing))
        scene.lt(bits, change={bits.ack: "0"}, ack=False).recessive(3).counters(0, 0).lt(scene.other)
        scene.play(received=[scene.other])


@shows("7.1.7")
def test_end_of_a_protocol_exception(kind: str) -> None:
    for timing, data in EXCEPTIONS:
        for recessive in (12, 11, 10):
            bits = exceptional(kind, data)
            scene = Scene(kind, False, iut=Iut(kind, NOMINAL_FD, timing))
            scene.lt(bits, change={bits.ack: "0"}, ack=False).recessive(recessive - 8)
            heard = [scene.other]
            if recessive == 10:
                missed = lay_out(scene.other)
                scene.lt(missed, change={missed.ack: "0"}, ack=False).recessive(3)
                heard = [scene.e]
                scene.lt(scene.e)
            else:
                scene.lt(scene.other)
            scene.counters(0, 0).play(received=heard)


@shows("7.1.8")
def test_dlc_above_8(kind: str) -> None:
    for dlc in range(9, 16):
        spec = Spec(0x321, b"\x01\x02\x03\x04\x05\x06\x07\x08", dlc=dlc)
        Scene(kind, False).lt(spec).play(received=[spec])


@shows("7.1.9")
def test_frames_without_idle_time(kind: str) -> None:
    for fd in formats(kind):
        for intermission in (2, 3):
            scene = Scene(kind, fd)
            scene.lt(scene.other).recessive(intermission).lt(scene.e).play(received=[scene.other, scene.e])


def stuffed_frames(texts: str, *, extended: bool, fd: bool, only_first: bool = False) -> list[Spec]:
    """The frames of a stuffing table; controllers that know FD get its classic frames with FDF 0."""
    found = []
    for text in texts.split("ID/CTRL/data: ")[-1].split("; "):
        text = text.removesuffix(" (remote)").split(" (remote,")[0]
        found.append(pattern(text, extended=extended, fd=fd, only_first=only_first))
    return found


def classic_stuffed(kind: str, *, extended: bool) -> list[Spec]:
    table = STUFF_EXT_CLASSIC if extended else STUFF_BASE_CLASSIC
    frames = stuffed_frames(table, extended=extended, fd=False)
    if WHAT[kind] == "classic":
        return frames
    return [spec.but(reserved=tuple((n, v) for n, v in spec.reserved if n != "FDF")) for spec in frames]


def fd_stuffed(*, extended: bool, only_first: bool = False) -> list[Spec]:
    table = STUFF_EXT_FD if extended else STUFF_BASE_FD
    return stuffed_frames(table, extended=extended, fd=True, only_first=only_first)


def stuffing(kind: str, *, extended: bool) -> None:
    frames = classic_stuffed(kind, extended=extended)
    if kind == "fd":
        frames += fd_stuffed(extended=extended)
    for spec in frames:
        bits = lay_out(spec)
        assert bits.stuffs()
        Scene(kind, False).lt(bits).play(received=[spec])


@shows("7.1.10")
def test_stuff_bits_of_base_frames(kind: str) -> None:
    stuffing(kind, extended=False)


@shows("7.1.11")
def test_stuff_bits_of_extended_frames(kind: str) -> None:
    stuffing(kind, extended=True)


@shows("7.1.12")
def test_valid_from_the_last_but_one_eof_bit_on(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        bits = lay_out(scene.other)
        last_but_one = bits.index("EOF", 7)
        scene.lt(bits, change={last_but_one: "0"}).flag().between().play(received=[scene.other])
