"""ISO 16845-1, 7.2: what a receiver must see as an error."""

from __future__ import annotations

from canwire import ControllerOptions, core
from tests.bus.can.reference_bits import CRC_17, opposite, remainder
from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene, formats
from tests.iso16845.test_receiver_frames import classic_stuffed, fd_stuffed

# first byte and the others: frames whose data fields have a stuff bit at every place a stuff bit can have
LONG = [
    (0x10, 0x78),
    (0x78, 0x3C),
    (0x34, 0x1E),
    (0x12, 0x0F),
    (0x0F, 0x87),
    (0x17, 0xC3),
    (0x43, 0xE1),
    (0x21, 0xF0),
]
SHORT, LARGE = Spec(0x155, b"\x12\x34", fd=True), Spec(0x155, b"\x12\x34" * 10, fd=True)


def inverted(bits: Bits, at: int) -> dict[int, str]:
    return {at: "0" if bits.levels[at] == "1" else "1"}


def disturb(scene: Scene, bits: Bits, at: int, *, passive: bool = False) -> Scene:
    """One bit of the tester's frame inverted: the flag comes in the next bit."""
    scene.lt(bits, change=inverted(bits, at), until=at)
    if passive:
        scene.passive_flag()
    else:
        scene.flag()
    scene.between()
    return scene


def each(iut: Iut, places: list[tuple[Bits, int]], *, passive: bool = False) -> None:
    """One after the other with the same controller, its REC set back each time."""
    for bits, at in places:
        iut.preset(tec=136 if passive else 0)
        scene = disturb(Scene(iut.kind, False, iut=iut), bits, at, passive=passive)
        scene.counters(rec=1).play(received=[], settling=1)


def each_restricted(kind: str, places: list[tuple[Bits, int]]) -> None:
    """No flag, nothing counted; 11 recessive bits later the controller takes part again, and acknowledges."""
    iut = Iut(kind, options=ControllerOptions(restricted=True))
    good = Spec(0x555)
    for bits, at in places:
        iut.preset(tec=5, rec=9)
        scene = Scene(kind, False, iut=iut)
        scene.lt(bits, change=inverted(bits, at), until=at).recessive(11)
        scene.lt(good).counters(5, 9).play(received=[good], settling=1)


def stuff_places(kind: str, *, extended: bool) -> list[tuple[Bits, int]]:
    frames = classic_stuffed(kind, extended=extended)
    if extended:
        frames.append(Spec(0, b"\x00", extended=True))
    laid = [lay_out(spec) for spec in frames]
    if kind == "fd":
        laid += [lay_out(spec) for spec in fd_stuffed(extended=extended, only_first=True)]
    return [(bits, at) for bits in laid for at in bits.stuffs()]


def long_places() -> list[tuple[Bits, int]]:
    """126 places of stuff bits in each of eight long data fields; the interpreted core gets every tenth."""
    places = []
    for first, others in LONG:
        bits = lay_out(Spec(0x555, bytes([first]) + bytes([others]) * 63, fd=True))
        found = [at for at in bits.stuffs() if bits.names[at] in ("DATA",)]
        if len(found) == 125:
            found.append(bits.stuffs("fixed")[0])
        assert len(found) == 126, len(found)
        places += [(bits, at) for at in found]
    assert len(places) == 1008
    return places if core.core_mode() == "compiled" else places[::10]


@shows("7.2.1")
def test_own_acknowledge_made_recessive(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        bits = lay_out(scene.other)
        scene.lt(bits, change={bits.ack: "1"}, until=bits.ack).flag().between().counters(rec=1).play(
            received=[]
        )


@shows("7.2.2")
def test_stuff_bits_of_base_frames(kind: str) -> None:
    each(Iut(kind), stuff_places(kind, extended=False))


@shows("7.2.2.a")
def test_stuff_bits_of_base_frames_when_passive(kind: str) -> None:
    each(Iut(kind), stuff_places(kind, extended=False), passive=True)


@shows("7.2.2.b")
def test_stuff_bits_of_base_frames_in_restricted_operation(kind: str) -> None:
    each_restricted(kind, stuff_places(kind, extended=False))


@shows("7.2.3")
def test_stuff_bits_of_extended_frames(kind: str) -> None:
    each(Iut(kind), stuff_places(kind, extended=True))


@shows("7.2.3.a")
def test_stuff_bits_of_extended_frames_when_passive(kind: str) -> None:
    each(Iut(kind), stuff_places(kind, extended=True), passive=True)


@shows("7.2.3.b")
def test_stuff_bits_of_extended_frames_in_restricted_operation(kind: str) -> None:
    each_restricted(kind, stuff_places(kind, extended=True))


@shows("7.2.4")
def test_stuff_bits_of_long_frames(kind: str) -> None:
    each(Iut(kind), long_places())


@shows("7.2.4.a")
def test_stuff_bits_of_long_frames_when_passive(kind: str) -> None:
    each(Iut(kind), long_places(), passive=True)


@shows("7.2.4.b")
def test_stuff_bits_of_long_frames_in_restricted_operation(kind: str) -> None:
    each_restricted(kind, long_places())


def crc_error(kind: str, bits: Bits, *, acknowledged: bool = False) -> None:
    """The whole frame up to the ACK delimiter passes, unacknowledged by the controller; then its flag."""
    until = bits.names.index("ACK DEL")
    change = {bits.ack: "0"} if acknowledged else {}
    scene = Scene(kind, bits.spec.fd)
    scene.lt(bits, change=change, until=until, ack=False).flag().between().counters(0, 1).play(received=[])


def late_crc_error(bits: Bits) -> None:
    """Others acknowledge for two bits: the ACK delimiter, and the flag behind it, come one bit later."""
    delimiter = bits.names.index("ACK DEL")
    scene = Scene("fd", True)
    scene.lt(bits, change={bits.ack: "0", delimiter: "0"}, until=delimiter, ack=False).recessive(1)
    scene.flag().between().counters(0, 1).play(received=[])


def changed_check(spec: Spec, level: str) -> Bits:
    """The frame with one CRC bit of this level inverted, stuffed to fit."""
    good = lay_out(spec)
    width = 15 if not spec.fd else 17 if len(spec.data) <= 16 else 21
    plain = [k for k, name in enumerate(good.names) if name == "CRC" and not good.stuff[k]]
    assert len(plain) == width
    nth = next(n for n, k in enumerate(plain) if good.levels[k] == level and n > 2)
    return lay_out(spec, crc_change=1 << width - 1 - nth)


@shows("7.2.5")
def test_crc_of_the_own_format(kind: str) -> None:
    for spec in [Spec(0x155, b"\x12\x34"), *([SHORT, LARGE] if kind == "fd" else [])]:
        for level in "01":
            for acknowledged in (False, True):
                crc_error(kind, changed_check(spec, level), acknowledged=acknowledged)
    missing_sof(kind)
    if kind == "fd":
        for spec in (SHORT, LARGE):
            crc_error(kind, lay_out(spec, parity_change=True))
            late_crc_error(changed_check(spec, "0"))
        lost_bits()


def missing_sof(kind: str) -> None:
    """Without its SOF, ID 001 is read as another one: bit 1 as SOF, a stuff bit as one of the identifier."""
    bits = lay_out(Spec(0x001))
    until = bits.names.index("ACK DEL")
    scene = Scene(kind, False)
    scene.lt(bits, change={0: "-"}, until=until, ack=False).flag().between().counters(0, 1).play(received=[])


def lost_bits() -> None:
    """One of five dominant bits lost, twice, where that leaves the CRC as it is: only the stuff count tells."""
    spec, lost = quiet_runs()
    bits = lay_out(spec)
    for at in reversed(lost):
        assert bits.levels[at - 1 : at + 6] == "1000001"
        assert bits.stuff[at + 5] == "dynamic"
        bits.levels = bits.levels[:at] + bits.levels[at + 1 :]
        bits.stuff[at + 5] = ""
        for column in (bits.names, bits.stuff, bits.fast):
            del column[at]  # type: ignore[attr-defined]
    crc_error("fd", bits)


def quiet_runs() -> tuple[Spec, list[int]]:
    """A frame with two runs of five dominant data bits that find the CRC register at 0, and where they begin."""
    head = lay_out(Spec(0x155, bytes(16), fd=True))
    plain = head.index("DATA")
    wire, data, lost = head.levels[:plain], "", []

    def feed(bit: str) -> None:
        nonlocal wire, data
        wire, data = wire + bit, data + bit
        if wire[-5:] in ("00000", "11111"):
            wire += opposite(bit)

    for _ in range(2):
        while "1" in (register := remainder(wire, CRC_17, "1" + "0" * 16)):
            feed(register[0])
        lost.append(len(wire))
        for _ in range(5):
            feed("0")
    data = (data + "10" * 64)[:128]
    return Spec(0x155, int(data, 2).to_bytes(16, "big"), fd=True), lost


@shows("7.2.6")
def test_crc_error_and_dominant_crc_delimiter(kind: str) -> None:
    for spec in [Spec(0x155, b"\x12\x34"), *([SHORT, LARGE] if kind == "fd" else [])]:
        for level in "01":
            bits = changed_check(spec, level)
            scene = Scene(kind, spec.fd)
            disturb(scene, bits, bits.index("CRC DEL")).counters(0, 1).play(received=[])


@shows("7.2.7")
def test_dominant_crc_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        bits = lay_out(scene.other)
        disturb(scene, bits, bits.index("CRC DEL")).counters(0, 1).play(received=[])


def fixed_stuff_places(level: str = "") -> list[tuple[Bits, int]]:
    """Every fixed stuff bit of CRC-17 and CRC-21, of both levels."""
    places = []
    for length, count in ((2, 6), (20, 7)):
        for position in range(count):
            for wanted in level or "01":
                places.append(with_fixed_stuff_bit(length, position, wanted))
    return places


def with_fixed_stuff_bit(length: int, position: int, level: str) -> tuple[Bits, int]:
    """Some frame whose fixed stuff bit there has this level."""
    for id in range(0x200):
        bits = lay_out(Spec(id, b"\x12" * (length - 1) + bytes([id % 3]), fd=True))
        at = bits.stuffs("fixed")[position]
        if bits.levels[at] == level:
            return bits, at
    raise AssertionError("no such frame")


@shows("7.2.8")
def test_fixed_stuff_bits(kind: str) -> None:
    places = fixed_stuff_places()
    assert len(places) >= 22
    each(Iut(kind), places)


@shows("7.2.9")
def test_dominant_ack_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        dominant_ack_delimiter(scene).flag().between().counters(0, 1).play(received=[])


def dominant_ack_delimiter(scene: Scene) -> Scene:
    """Up to and including that bit; FD tolerates a second ACK bit, the third dominant one is the delimiter."""
    bits = lay_out(scene.other)
    delimiter = bits.index("ACK DEL")
    scene.lt(bits, change={delimiter: "0"}, until=delimiter)
    if scene.fd:
        scene.dominant(1)
    return scene


@shows("7.2.10")
def test_dominant_eof_bit(kind: str) -> None:
    for fd in formats(kind):
        for bit in range(1, 6):
            scene = Scene(kind, fd)
            bits = lay_out(scene.other)
            disturb(scene, bits, bits.index("EOF", bit)).play(received=[])


@shows("7.2.11")
def test_dominant_sixth_eof_bit(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd)
        scene.lt(scene.e).recessive(3)
        bits = lay_out(scene.other)
        disturb(scene, bits, bits.index("EOF", 6)).play(received=[scene.e])
