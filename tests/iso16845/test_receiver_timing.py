"""ISO 16845-1, 7.7: bit timing of a receiver, classic frames."""

from __future__ import annotations

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut, segmented
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene

S = Spec(0x7FF)  # identifier bits 6 and 12 on the wire are dominant stuff bits
CLEAR = 1_000  # ps: how far levels stay clear of the instant of a sample


class Timed(Scene):
    """A scene with the controller's segments at hand, in quanta."""

    def __init__(self, kind: str, *, ps2: int = 0, sjw: int = 0) -> None:
        usual = Iut(kind).timing
        timing = segmented(kind, ps2 or usual.tseg2, sjw or usual.sjw)
        super().__init__(kind, False, iut=Iut(kind, timing))
        assert self.iut.timing.jump == timing.sjw
        self.ntq, self.tseg1, self.tseg2 = timing.quanta, timing.tseg1, timing.tseg2
        self.sjw = self.iut.line.controller.jump_ps // self.tq  # an MCP2515 wants it shorter than PS2


def stuff_bits_of_s() -> tuple[Bits, int, int]:
    bits = lay_out(S)
    first, second = bits.stuffs()[:2]
    assert (first, second) == (6, 12)
    assert bits.levels[first] == bits.levels[second] == "0"
    return bits, first, second


@shows("7.7.1")
def test_sample_point(kind: str) -> None:
    for ps2 in (2, 3, 4):
        scene = Timed(kind, ps2=ps2, sjw=ps2)
        bits, first, second = stuff_bits_of_s()
        uncorrected = max(0, scene.ps2 - CLEAR - scene.sjw * scene.tq)
        scene.lt(bits, until=second, lengths={first: CLEAR - scene.ps2, second: -scene.ps2 - scene.tq})
        scene.skip(scene.ps2 + scene.tq + uncorrected).flag().between().counters(0, 1).play(received=[])


@shows("7.7.2")
def test_hard_synchronisation_in_the_third_intermission_bit(kind: str) -> None:
    for e in range(1, Timed(kind).ntq + 1):
        scene = Timed(kind)
        scene.disturbed().flag().recessive(8 + 2).bits("-", bit_ps=e * scene.tq)
        scene.dominant(6).flag().between().counters(0, 2).play(received=[])


@shows("7.7.3")
def test_late_edge_within_the_jump_width(kind: str) -> None:
    for e in range(1, Timed(kind).sjw + 1):
        scene = Timed(kind)
        late_edge(scene, e, -scene.ps2 - scene.tq)
        scene.skip(scene.ps2 + scene.tq).flag().between().counters(0, 1).play(received=[])


def late_edge(scene: Timed, e: int, longer_ps: int) -> None:
    """The first dominant stuff bit comes e quanta late, and is so much longer."""
    bits, first, _ = stuff_bits_of_s()
    scene.lt(bits, until=first, lengths={first - 1: e * scene.tq, first: longer_ps})


@shows("7.7.4")
def test_late_edge_beyond_the_jump_width(kind: str) -> None:
    usual = Timed(kind)
    for e in range(usual.sjw + 1, usual.ntq - usual.tseg2):
        scene = Timed(kind)
        shorter = scene.ps2 + (1 + e - scene.sjw) * scene.tq
        late_edge(scene, e, -shorter)
        scene.skip(shorter - (e - scene.sjw) * scene.tq).flag().between().counters(0, 1).play(received=[])


def early_edge(scene: Timed, e: int) -> None:
    """A recessive bit ends e quanta early, in one quantum of dominance; the error flag comes next."""
    bits, first, _ = stuff_bits_of_s()
    early_ps = e * scene.tq - (CLEAR if e == scene.tseg2 else 0)
    scene.lt(bits, until=first - 1)
    scene.force("0", scene.now_ps - early_ps, scene.tq)
    scene.recessive(1).skip(-min(early_ps, scene.sjw * scene.tq)).flag().between().counters(0, 1)
    scene.play(received=[])


@shows("7.7.5")
def test_early_edge_within_the_jump_width(kind: str) -> None:
    for e in range(1, Timed(kind).sjw + 1):
        early_edge(Timed(kind), e)


@shows("7.7.6")
def test_early_edge_beyond_the_jump_width(kind: str) -> None:
    usual = Timed(kind)
    for e in range(usual.sjw + 1, usual.tseg2 + 1):
        early_edge(Timed(kind), e)


def glitch_in_the_stuff_bit(scene: Timed, early_ps: int) -> None:
    """The first stuff bit comes early or in time; its third quantum is recessive, and so are the next six bits."""
    bits, first, second = stuff_bits_of_s()
    scene.lt(bits, until=second, change={second: "-"}, lengths={first - 1: -early_ps})
    scene.force("1", scene.starts[first] + 2 * scene.tq, scene.tq)
    assert scene.now_ps - scene.starts[first] == 7 * scene.n_ps
    scene.flag().between().counters(0, 1).play(received=[])


@shows("7.7.7")
def test_one_synchronisation_a_bit(kind: str) -> None:
    glitch_in_the_stuff_bit(Timed(kind), 0)


@shows("7.7.8")
def test_one_synchronisation_a_bit_behind_an_early_edge(kind: str) -> None:
    scene = Timed(kind)
    glitch_in_the_stuff_bit(scene, scene.tq)


@shows("7.7.9.1")
def test_pulse_on_the_idle_bus(kind: str) -> None:
    scene = Timed(kind)
    scene.bits("0", bit_ps=(scene.tseg1 - 1) * scene.tq).recessive(8).counters(0, 0)
    scene.lt(scene.other).counters(0, 0).play(received=[scene.other])


@shows("7.7.9.2")
def test_pulses_on_the_idle_bus(kind: str) -> None:
    scene = Timed(kind)
    half = (scene.tseg1 - 2) * scene.tq // 2
    for level, width_ps in (
        ("0", half),
        ("-", 2 * scene.tq),
        ("0", half - CLEAR),
        ("-", scene.tq + 2 * CLEAR),
    ):
        scene.bits(level, bit_ps=width_ps)
    assert abs(scene.now_ps - scene.sample_ps) <= 2 * CLEAR  # the sample point met the last gap
    scene.bits("0", bit_ps=(scene.tseg1 - 2) * scene.tq).recessive(8).counters(0, 0)
    scene.lt(scene.other).counters(0, 0).play(received=[scene.other])


@shows("7.7.10")
def test_no_synchronisation_behind_a_dominant_sample(kind: str) -> None:
    scene = Timed(kind)
    bits = lay_out(Spec(0b11111000000))
    first, second = bits.stuffs()[:2]
    assert (bits.levels[first], bits.levels[second], second - first) == ("0", "1", 5)
    scene.lt(bits, until=second, change={second: "0"})
    scene.force("1", scene.starts[first] + scene.sample_ps + CLEAR, scene.tq)
    assert scene.now_ps - scene.starts[first] == 6 * scene.n_ps
    scene.flag().between().counters(0, 1).play(received=[])


@shows("7.7.11")
def test_early_edge_at_the_ack_slot(kind: str) -> None:
    for e in range(1, Timed(kind).sjw + 1):
        scene = Timed(kind)
        scene.iut.preset(rec=9)
        bits = lay_out(scene.other)
        scene.lt(bits, ack=False)
        slot, early_ps = scene.starts[bits.ack], e * scene.tq
        end_ps = slot + scene.sample_ps - early_ps + CLEAR
        scene.force("0", slot - early_ps, end_ps - slot + early_ps)
        scene.force("1", end_ps, slot + scene.n_ps - end_ps)
        scene.drives(slot - early_ps, scene.n_ps).counters(0, 8).play(received=[scene.other])
