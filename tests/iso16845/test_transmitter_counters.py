"""ISO 16845-1, 8.6 and 9.6: the transmit error counter, and both counters together."""

from __future__ import annotations

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene, formats, stuff_bit
from tests.iso16845.test_receiver_errors import inverted
from tests.iso16845.test_transmitter_errors import ack_delimiter_error, disturb_sender, unacknowledged


@shows("8.6.1")
def test_disturbed_bit_of_its_active_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 6):
            scene = Scene(kind, fd).disturbed_sender().counters(8, 0).forced(bit - 1).counters(8, 0)
            scene.forced(1, 1).counters(16, 0).flag().between().again().counters(15, 0).play(received=[])


@shows("8.6.2")
def test_disturbed_bit_of_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        for bit in (1, 3, 4, 6):
            scene = Scene(kind, fd).overloaded_sender().forced(bit - 1).counters(0, 0).forced(1, 1)
            scene.counters(8, 0).flag().between().counters(8, 0).play(received=[])


@shows("8.6.3")
def test_long_dominance_behind_its_active_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed_sender().flag().counters(8, 0)
        for bits, tec in ((7, 8), (1, 16), (7, 16), (1, 24)):
            scene.dominant(bits).counters(tec, 0)
        scene.between().again().counters(23, 0).play(received=[])


@shows("8.6.4")
def test_long_dominance_behind_its_passive_flag(kind: str) -> None:
    for fd in formats(kind):
        for bits, change in ((1, 7), (6, 7), (8, 15), (9, 15), (16, 23)):
            scene = Scene(kind, fd, tec=130).disturbed_sender(passive=True).counters(138, 0).passive_flag()
            scene.dominant(bits).counters(130 + change + 1, 0).between().recessive(8)
            scene.again(passive=True).counters(130 + change, 0).play(received=[])


@shows("8.6.5")
def test_long_dominance_behind_its_overload_flag(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).overloaded_sender().flag().counters(0, 0)
        for bits, tec in ((7, 0), (1, 8), (7, 8), (1, 16), (7, 16)):
            scene.dominant(bits).counters(tec, 0)
        scene.between().counters(16, 0).play(received=[])


def places(bits: Bits, names: dict[str, str]) -> list[int]:
    return [bits.plain(name, level) for name, levels in names.items() for level in levels]


@shows("8.6.6")
def test_bit_errors(kind: str) -> None:
    fields = {"SOF": "0", "ID": "0", "DLC": "01", "DATA": "01", "CRC": "01"}
    specs = [Spec(0x155, b"\x5a")]
    if kind == "fd":
        specs += [Spec(0x155, b"\x5a", fd=True), Spec(0x155, b"\x5a" * 20, fd=True)]
    for spec in specs:
        bits = lay_out(spec)
        for at in places(bits, fields):
            scene = disturb_sender(Scene(kind, spec.fd, tec=8), bits, at).counters(15, 0)
            scene.check_at(0, tec=16).play(received=[])


@shows("8.6.7")
def test_form_errors(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd)
        bits = lay_out(spec)
        errors = [bits.index("CRC DEL"), *(bits.index("EOF", bit) for bit in (1, 4, 7))]
        for at in [*errors, *bits.stuffs("fixed")[:2]]:
            scene = disturb_sender(Scene(kind, fd, tec=8), bits, at).counters(15, 0)
            scene.check_at(0, tec=16).play(received=[])
        ack_delimiter_error(Scene(kind, fd, tec=8), spec).counters(15, 0).play(received=[])
    if kind == "fd":
        bits = lay_out(Spec(0x155, b"\x5a" * 20, fd=True))
        disturb_sender(Scene(kind, True), bits, bits.stuffs("fixed")[3]).counters(7, 0).play(received=[])


@shows("8.6.8")
def test_acknowledgement_error(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd)
        scene = unacknowledged(Scene(kind, fd), spec).counters(8, 0).flag().between()
        scene.sends(spec, ask=False).counters(7, 0).play(received=[])


@shows("8.6.9")
def test_form_error_in_its_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 4, 7):
            scene = Scene(kind, fd).disturbed_sender().flag().recessive(bit - 1).counters(8, 0).dominant(1)
            scene.counters(16, 0).flag().between().again().counters(15, 0).play(received=[])


@shows("8.6.10")
def test_form_error_in_its_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        for bit in (2, 7):
            scene = Scene(kind, fd).overloaded_sender().flag().recessive(bit - 1).counters(0, 0).dominant(1)
            scene.counters(8, 0).flag().between().counters(8, 0).play(received=[])


@shows("8.6.11")
def test_good_frame(kind: str) -> None:
    for fd in formats(kind):
        for tec in (2, 127):
            scene = Scene(kind, fd, tec=tec)
            scene.sends(scene.other).check_at(len(lay_out(scene.other).levels) - 1, tec=tec)
            scene.counters(tec - 1, 0).play(received=[])


@shows("8.6.12")
def test_good_frame_when_passive(kind: str) -> None:
    for fd in formats(kind):
        for tec in (128, 255):
            scene = Scene(kind, fd, tec=tec)
            bits = lay_out(scene.other.but(esi=fd))
            scene.ask(scene.other).sends(bits, ask=False).check_at(len(bits.levels) - 1, tec=tec)
            scene.counters(tec - 1, 0).play(received=[])


@shows("8.6.13")
def test_overload_flag_of_13_bits(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=8).overloaded_sender().bits("0" * 6, "0" * 6).dominant(7)
        scene.between().counters(7, 0).play(received=[])


@shows("8.6.14")
def test_error_flag_of_13_bits(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed_sender().flag().dominant(7).between().counters(8, 0)
        scene.again().counters(7, 0).play(received=[])


@shows("8.6.15")
def test_dominant_last_bit_of_the_overload_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=8).overloaded_sender().flag().recessive(7).dominant(1)
        scene.flag().between().counters(7, 0).play(received=[])


@shows("8.6.16")
def test_dominant_last_bit_of_the_error_delimiter(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd).disturbed_sender().flag().recessive(7).dominant(1)
        scene.flag().between().counters(8, 0).again().counters(7, 0).play(received=[])


@shows("8.6.17")
def test_lone_acknowledgement_error_when_passive(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd, esi=fd)
        scene = unacknowledged(Scene(kind, fd, tec=130), spec).passive_flag().between().counters(130, 0)
        scene.recessive(8).sends(spec, ask=False).counters(129, 0).play(received=[])


@shows("8.6.18")
def test_dominant_bit_in_the_flag_behind_an_acknowledgement_error(kind: str) -> None:
    for fd in formats(kind):
        spec = Spec(0x155, b"\x5a", fd=fd, esi=fd)
        scene = unacknowledged(Scene(kind, fd, tec=130), spec).recessive(5).counters(130, 0).dominant(1)
        scene.counters(138, 0).recessive(6).between().recessive(8)
        scene.sends(spec, ask=False).counters(137, 0).play(received=[])


@shows("8.6.19")
def test_recessive_stuff_bit_in_the_arbitration_field(kind: str) -> None:
    for fd in formats(kind):
        bits = lay_out(Spec(0x400, b"\x55", fd=fd))
        at = bits.index("ID", 7)
        assert bits.stuff[at]
        assert bits.levels[at] == "1"
        scene = disturb_sender(Scene(kind, fd, tec=8), bits, at).counters(7, 0).check_at(0, tec=8)
        scene.play(received=[])


def outranked(kind: str, fd: bool) -> tuple[Scene, Bits, Bits, int]:
    """ID 051 loses to 050 at the last bit."""
    scene = Scene(kind, fd, tec=8)
    mine, theirs = lay_out(scene.e.but(id=0x051)), lay_out(scene.e.but(id=0x050))
    lost = next(k for k in range(20) if mine.levels[k] != theirs.levels[k])
    assert lost == [k for k, name in enumerate(mine.names) if name == "ID" and not mine.stuff[k]][-1]
    scene.ask(mine.spec)
    return scene, mine, theirs, lost


@shows("8.6.20")
def test_good_reception(kind: str) -> None:
    for fd in formats(kind):
        scene, mine, theirs, lost = outranked(kind, fd)
        scene.lt(theirs, drives=mine.levels[: lost + 1]).recessive(3).counters(8, 0)
        scene.sends(mine, ask=False).counters(7, 0).play(received=[theirs.spec])


@shows("8.6.21")
def test_error_in_the_winners_frame(kind: str) -> None:
    for fd in formats(kind):
        scene, mine, theirs, lost = outranked(kind, fd)
        at = stuff_bit(theirs)
        scene.lt(theirs, change=inverted(theirs, at), until=at, drives=mine.levels[: lost + 1])
        scene.counters(8, 1).flag().between().counters(8, 1)
        scene.sends(mine, ask=False).counters(7, 1).play(received=[])


@shows("9.6.1")
def test_errors_as_transmitter_behind_a_high_rec(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, rec=127)
        bits = lay_out(scene.e)
        scene.ask(scene.e)
        for attempt in range(1, 17):
            scene.sends(bits, change={stuff_bit(bits): "0"}, until=stuff_bit(bits), ask=False)
            scene.counters(8 * attempt, 127).flag().between()
        scene.recessive(8)
        passive = lay_out(scene.e.but(esi=fd))
        scene.sends(passive, change={stuff_bit(passive): "0"}, until=stuff_bit(passive), ask=False)
        scene.counters(136, 127).passive_flag().between().recessive(8).again(passive=True)
        scene.counters(135, 127).play(received=[])


@shows("9.6.2")
def test_errors_as_receiver_behind_a_high_tec(kind: str) -> None:
    for fd in formats(kind):
        scene = Scene(kind, fd, tec=127)
        for rec in range(1, 129):
            scene.disturbed().counters(127, rec).flag().between()
        scene.disturbed().counters(127, 129).passive_flag().between().counters(127, 129).play(received=[])
