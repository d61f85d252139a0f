"""ISO 16845-1, 7.6: the receive error counter."""

from __future__ import annotations

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import NOMINAL_FD, Iut
from tests.iso16845.purposes import WHAT, shows
from tests.iso16845.scenes import Scene, formats, stuff_bit
from tests.iso16845.test_receiver_errors import (
    LARGE,
    SHORT,
    changed_check,
    disturb,
    dominant_ack_delimiter,
    fixed_stuff_places,
)
from tests.iso16845.test_receiver_frames import EXCEPTIONS, exceptional


@shows("7.6.1")
def test_disturbed_bit_of_its_active_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd).disturbed().counters(0, 1).forced(bit - 1).counters(0, 1).forced(1, 1)
            scene.counters(0, 9).flag().between().counters(0, 9).play(received=[])


@shows("7.6.2")
def test_disturbed_bit_of_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd).overloaded().forced(bit - 1).counters(0, 0).forced(1, 1)
            scene.counters(0, 8).flag().between().counters(0, 8).play(received=[scene.other])


@shows("7.6.3")
def test_long_dominance_behind_its_error_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed().flag().counters(0, 1)
        for bits, rec in ((1, 9), (6, 9), (1, 17), (7, 17), (1, 25)):
            scene.dominant(bits).counters(0, rec)
        scene.between().counters(0, 25).play(received=[])


@shows("7.6.4")
def test_long_dominance_behind_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).overloaded().flag()
        for bits, rec in ((7, 0), (1, 8), (7, 8), (1, 16)):
            scene.dominant(bits).counters(0, rec)
        scene.between().counters(0, 16).play(received=[scene.other])


@shows("7.6.5")
def test_bit_error_in_the_ack_slot(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        bits = lay_out(scene.other)
        scene.lt(bits, change={bits.ack: "1"}, until=bits.ack).counters(0, 1)
        scene.flag().between().counters(0, 1).play(received=[])


@shows("7.6.6")
def test_form_error_at_the_crc_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        bits = lay_out(scene.other)
        disturb(scene, bits, bits.index("CRC DEL")).counters(0, 1).play(received=[])


@shows("7.6.7")
def test_form_error_at_the_ack_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=9)
        dominant_ack_delimiter(scene).counters(0, 9).flag().between().counters(0, 9)
        scene.check_at(lay_out(scene.other).ack + 1, rec=8)
        scene.play(received=[])


@shows("7.6.8")
def test_form_error_in_the_eof(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 3, 5):
            scene = Scene(kind, fd, rec=9)
            bits = lay_out(scene.other)
            at = bits.index("EOF", bit)
            scene.lt(bits, change={at: "0"}, until=at).check_at(bits.ack + 1, rec=8).check_at(at, rec=8)
            scene.counters(0, 9).flag().between().counters(0, 9).play(received=[])


def stuffed_fields(kind: str, *, fd: bool) -> list[tuple[Bits, int]]:
    """A stuff bit of each level in the arbitration, control, data and (classic) CRC field."""
    found = []
    for name in ("ID", "control", "DATA", *(() if fd else ("CRC",))):
        for level in "10":
            found.append(stuffed(kind, name, level, fd=fd))
    return found


def stuffed(kind: str, field: str, level: str, *, fd: bool) -> tuple[Bits, int]:
    """Some frame with a stuff bit of this level in this field."""
    names = ("FDF", "r0", "res", "BRS", "ESI", "DLC") if field == "control" else (field,)
    for spec in candidates(kind, fd=fd):
        bits = lay_out(spec)
        for at in bits.stuffs(level=level):
            if bits.names[at] in names and bits.levels[at] == level:
                return bits, at
    raise AssertionError(f"no stuff bit {level} in {field}")


def candidates(kind: str, *, fd: bool) -> list[Spec]:
    octets = (b"\x80", b"\x7f", b"\x12", b"\x00\x00", b"\xff\xff", b"\x3c" * 64 if fd else b"\x3c" * 8)
    specs = [
        Spec(id, data, fd=fd, esi=esi)
        for id in range(0x7FF, 0, -61)
        for data in octets
        for esi in (False, fd)
    ]
    if fd:
        return [*specs, Spec(0x155, b"\x01" * 64, fd=True, esi=True)]
    remote = [Spec(id, b"", remote=True, dlc=15) for id in range(0x7FF, 0, -1)]
    extended = [
        Spec(id, b"\x01", extended=True, remote=True, dlc=15) for id in range(0x1FFFFFFF, 0, -0xFFFFF)
    ]
    if WHAT[kind] == "classic":
        extended = [spec.but(reserved=(("FDF", "1"), ("r0", "1"))) for spec in extended]
    return [*specs, *remote, *extended]


@shows("7.6.9")
def test_stuff_errors(kind: str) -> None:
    for fd in formats(kind):
        for bits, at in stuffed_fields(kind, fd=fd):
            scene = Scene(kind, fd)
            scene.lt(bits, change={at: "0" if bits.levels[at] == "1" else "1"}, until=at)
            scene.check_at(at, rec=0).counters(0, 1).flag().between().counters(0, 1).play(received=[])


@shows("7.6.10")
def test_crc_error(kind: str) -> None:
    for spec in [Spec(0x155, b"\x12\x34"), *([SHORT, LARGE] if kind == "fd" else [])]:
        bits = changed_check(spec, "0")
        until = bits.names.index("ACK DEL")
        scene = Scene(kind, spec.fd)
        scene.lt(bits, until=until, ack=False).check_at(until, rec=0).counters(0, 1)
        scene.flag().between().counters(0, 1).play(received=[])


@shows("7.6.11")
def test_dominant_bit_behind_its_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed().flag().counters(0, 1).dominant(1).counters(0, 9)
        scene.between().counters(0, 9).play(received=[])


@shows("7.6.12")
def test_form_error_in_its_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 7):
            scene = Scene(kind, fd).disturbed().flag().recessive(bit - 1).counters(0, 1).dominant(1)
            scene.counters(0, 2).flag().between().counters(0, 2).play(received=[])


@shows("7.6.13")
def test_form_error_in_its_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 7):
            scene = Scene(kind, fd).overloaded().flag().recessive(bit - 1).counters(0, 0).dominant(1)
            scene.counters(0, 1).flag().between().counters(0, 1).play(received=[scene.other])


@shows("7.6.14")
def test_good_frame(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=9)
        bits = lay_out(scene.other)
        scene.lt(bits).check_at(bits.ack, rec=9).check_at(bits.ack + 1, rec=8)
        scene.counters(0, 8).play(received=[scene.other])


@shows("7.6.15")
def test_good_frame_when_passive(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=135)
        scene.lt(scene.other)
        iut = scene.play(received=[scene.other])
        assert (iut.rec in range(119, 128), iut.tec) == (True, 0)
        scene = Scene(kind, fd, iut=iut)  # and error active again
        scene.disturbed().flag().between().play(received=[])


@shows("7.6.16")
def test_dominant_last_eof_bit(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=9)
        scene.overloaded().counters(0, 8).flag().between().counters(0, 8).play(received=[scene.other])


@shows("7.6.17")
def test_overload_flag_of_13_bits(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=9)
        scene.overloaded().flag().dominant(7).between().counters(0, 8).play(received=[scene.other])


@shows("7.6.18")
def test_error_flag_of_13_bits(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed().flag().dominant(1).counters(0, 9).dominant(6)
        scene.counters(0, 9).between().counters(0, 9).play(received=[])


@shows("7.6.19")
def test_dominant_last_bit_of_the_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed().flag().recessive(7).dominant(1).counters(0, 1)
        scene.flag().between().counters(0, 1).play(received=[])


@shows("7.6.20")
def test_dominant_last_bit_of_the_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).overloaded().flag().recessive(7).dominant(1).counters(0, 0)
        scene.flag().between().counters(0, 0).play(received=[scene.other])


@shows("7.6.21")
def test_good_transmission(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=20)
        mine = lay_out(scene.e.but(id=0x300))
        theirs = lay_out(scene.e)
        at, lost = stuff_bit(theirs), next(k for k in range(12) if mine.levels[k] != theirs.levels[k])
        scene.ask(mine.spec).lt(theirs, change={at: "0"}, until=at, drives=mine.levels[: lost + 1])
        scene.counters(0, 21).flag().between().sends(mine, ask=False).counters(0, 21).play(received=[])


@shows("7.6.22")
def test_fixed_stuff_bits(kind: str) -> None:
    for bits, at in fixed_stuff_places():
        scene = Scene(kind, True)
        scene.lt(bits, change={at: "0" if bits.levels[at] == "1" else "1"}, until=at)
        scene.check_at(at, rec=0).counters(0, 1).flag().between().counters(0, 1).play(received=[])


@shows("7.6.23")
def test_protocol_exception(kind: str) -> None:
    for timing, data in EXCEPTIONS:
        bits = exceptional(kind, data)
        scene = Scene(kind, False, rec=9, iut=Iut(kind, NOMINAL_FD, timing))
        scene.lt(bits, change={bits.ack: "0"}, ack=False).recessive(3).counters(0, 9)
        scene.lt(scene.other).counters(0, 8).play(received=[scene.other])
