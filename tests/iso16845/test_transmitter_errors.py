"""ISO 16845-1, 8.2: what a transmitter must see as an error."""

from __future__ import annotations

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut
from tests.iso16845.purposes import shows
from tests.iso16845.rows.terms import STUFF_BASE_FD
from tests.iso16845.scenes import Scene, formats
from tests.iso16845.test_receiver_errors import fixed_stuff_places, inverted, long_places
from tests.iso16845.test_receiver_frames import stuffed_frames
from tests.iso16845.test_transmitter_frames import STUFF_BASE, STUFF_EXT

STUFF_EXT_DISTURBED = (
    "01E38787/6AE/F8; 11F38787/6A8/3C; 1079C1E1/6BE/1E; 083DF0F0/69F/0F; 041EF878/68F/87; 1F0C3C3C/683/C3; "
    "0F861E1E/6A3/E1; 07C30F0F/6A1/F0; 1C3FC3C3/6A0/-; 020FE1FF/6B0/-"
)


def disturb_sender(scene: Scene, bits: Bits, at: int, *, again: bool = True) -> Scene:
    """The controller sends this, one bit is inverted for it: error flag, then the frame once more."""
    passive = scene.iut.line.controller.passive
    spec = bits.spec.but(esi=False)
    scene.ask(spec).sends(bits, change=inverted(bits, at), until=at, ask=False)
    scene.recessive(6) if passive else scene.flag()
    scene.between()
    if passive:
        scene.recessive(8)
    if again:
        scene.sends(bits, ask=False)
    return scene


def bit_errors(kind: str, spec: Spec, names: dict[str, str]) -> int:
    """At an ordinary bit of each level in each field: a name, and the levels ("01") to be found there."""
    count = 0
    bits = lay_out(spec)
    for name, levels in names.items():
        for level in levels:
            disturb_sender(Scene(kind, spec.fd), bits, bits.plain(name, level)).counters(7, 0).play(
                received=[]
            )
            count += 1
    return count


CLASSIC_FIELDS = {
    "SOF": "0",
    "ID": "0",
    "RTR": "0",
    "DLC": "01",
    "DATA": "01",
    "CRC": "01",
    "ACK DEL": "1",
    "EOF": "1",
}


@shows("8.2.1")
def test_bit_errors_in_base_frames(kind: str) -> None:
    both = {**CLASSIC_FIELDS, "IDE": "0", "FDF": "0"}
    assert bit_errors(kind, Spec(0x155, b"\x5a"), both) == 13
    if kind == "fd":
        fields = {**both, "FDF": "1", "res": "0", "BRS": "1", "ESI": "0", "COUNT": "01"}
        for data in (b"\x5a", b"\x5a" * 20):
            fd_bit_errors(Spec(0x155, data, fd=True), fields)


def fd_bit_errors(spec: Spec, fields: dict[str, str]) -> None:
    """ACK delimiter apart, which needs two dominant bits more."""
    wanted = {name: levels for name, levels in fields.items() if name != "ACK DEL"}
    bits = lay_out(spec)
    for name, levels in wanted.items():
        for level in levels:
            if any(
                n == name and v == level and not s
                for n, v, s in zip(bits.names, bits.levels, bits.stuff, strict=True)
            ):
                at = bits.plain(name, level)
                disturb_sender(Scene("fd", True), bits, at).counters(7, 0).play(received=[])
    for level in "01":
        for at in bits.stuffs("fixed", level=level)[:1]:
            disturb_sender(Scene("fd", True), bits, at).counters(7, 0).play(received=[])
    ack_delimiter_error(Scene("fd", True), spec).counters(7, 0).play(received=[])


def ack_delimiter_error(scene: Scene, spec: Spec) -> Scene:
    """The ACK delimiter dominant; in FD behind an acknowledge of two bits."""
    bits = lay_out(spec)
    delimiter = bits.index("ACK DEL")
    scene.sends(bits, change={delimiter: "0"}, until=delimiter)
    if spec.fd:
        scene.dominant(1)
    scene.flag().between().sends(bits, ask=False)
    return scene


@shows("8.2.2")
def test_bit_errors_in_extended_frames(kind: str) -> None:
    both = {**CLASSIC_FIELDS, "EXT": "0", "FDF": "0", "r0": "0"}
    assert bit_errors(kind, Spec(0x15555555, b"\x5a", extended=True), both) == 14
    if kind == "fd":
        fields = {**both, "FDF": "1", "res": "0", "BRS": "1", "ESI": "0", "COUNT": "01"}
        del fields["r0"]
        for data in (b"\x5a", b"\x5a" * 20):
            fd_bit_errors(Spec(0x15555555, data, extended=True, fd=True), fields)


def stuff_errors(kind: str, specs: list[Spec], *, data_bits: int | None = None) -> int:
    """Every stuff bit, in FD up to payload byte 2; the frame is repeated each time."""
    count = 0
    for spec in specs:
        bits = lay_out(spec)
        for at in bits.stuffs():
            plain = [k for k in range(at) if bits.names[k] == "DATA" and not bits.stuff[k]]
            if spec.fd and (len(plain) > 16 or bits.names[at] == "CRC"):
                continue
            scene = Scene(kind, spec.fd, tec=200 if spec.esi else 0)
            # rule 3 spares stuff bits before RTR; what stands before IDE stands behind a base frame's RTR
            arbitration = ("ID", "EXT", "RTR", "SRR", *(["IDE"] if spec.extended else []))
            exempt = bits.names[at] in arbitration and bits.levels[at] == "1"
            disturb_sender(scene, bits, at)
            tec = (200 if spec.esi else 0) + (0 if exempt else 8)
            scene.counters(max(0, tec - 1), 0).play(received=[])
            count += 1
    return count


def sent(texts: str, *, extended: bool, fd: bool) -> list[Spec]:
    return [spec.but(reserved=()) for spec in stuffed_frames(texts, extended=extended, fd=fd, only_first=fd)]


@shows("8.2.3")
def test_stuff_bits_of_base_frames(kind: str) -> None:
    assert stuff_errors(kind, sent(STUFF_BASE, extended=False, fd=False)) == 35
    if kind == "fd":
        assert (
            stuff_errors(kind, sent(STUFF_BASE_FD.replace("107/28F", "107/08F"), extended=False, fd=True))
            >= 38
        )


@shows("8.2.4")
def test_stuff_bits_of_extended_frames(kind: str) -> None:
    specs = [*sent(STUFF_EXT, extended=True, fd=False), Spec(0, b"\x00", extended=True)]
    assert stuff_errors(kind, specs) == 42
    if kind == "fd":
        assert stuff_errors(kind, sent(STUFF_EXT_DISTURBED, extended=True, fd=True)) >= 70


@shows("8.2.5")
def test_form_errors(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd)
        bits = lay_out(spec)
        for at in (bits.index("CRC DEL"), *(bits.index("EOF", bit) for bit in (1, 4, 7))):
            disturb_sender(Scene(kind, fd), bits, at).counters(7, 0).play(received=[])
        ack_delimiter_error(Scene(kind, fd), spec).counters(7, 0).play(received=[])
    if kind == "fd":
        for bits, at in fixed_stuff_places():
            disturb_sender(Scene(kind, True), bits, at).counters(7, 0).play(received=[])


def unacknowledged(scene: Scene, spec: Spec) -> Scene:
    """Up to the bit in which the controller knows: the ACK slot, in FD the one behind it."""
    bits = lay_out(spec)
    scene.ask(spec.but(esi=False))
    scene.sends(bits, until=bits.ack + 1 if spec.fd else bits.ack, ack=False, ask=False)
    return scene


@shows("8.2.6")
def test_acknowledgement_error(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd)
        scene = unacknowledged(Scene(kind, fd), spec).counters(8, 0).flag().between()
        scene.sends(spec, ask=False).counters(7, 0).play(received=[])


@shows("8.2.7")
def test_late_and_long_acknowledge(kind: str) -> None:
    spec = Spec(0x155, b"\x5a", fd=True)
    for first, second in (("-", "0"), ("0", "0")):
        scene = Scene(kind, True)
        bits = lay_out(spec)
        scene.sends(bits, until=bits.ack - 1).bits(first + second).recessive(8 + 3)
        scene.ask(scene.e).sends(scene.e, ask=False).counters(0, 0).play(received=[])


@shows("8.2.8")
def test_stuff_bits_of_long_frames(kind: str) -> None:
    iut = Iut(kind)
    for bits, at in long_places():
        iut.preset()
        scene = Scene(kind, True, iut=iut)
        scene.single_shot = True
        disturb_sender(scene, bits, at, again=False).counters(8, 0).play(received=[], settling=1)
