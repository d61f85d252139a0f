"""ISO 16845-1, 8.7 and 8.8: bit timing of a transmitter, classic frames and FD."""

from __future__ import annotations

from typing import Self

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import NOMINAL_FD, Iut, segmented_data
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene
from tests.iso16845.test_receiver_fd_timing import Fast
from tests.iso16845.test_receiver_timing import CLEAR, Timed

CLASSIC_SEGMENTS = (2, 4, 6)  # PS2 in quanta
SEGMENTS = {
    "fd": (4, 10, 15), "tolerant": CLASSIC_SEGMENTS, "sja1000": CLASSIC_SEGMENTS, "mcp2515": CLASSIC_SEGMENTS
}  # fmt: skip
ALTERNATING = Spec(0x155, b"\x55")


def sample_points(kind: str, *, sjw: int = 1) -> list[Timed]:
    return [Timed(kind, ps2=ps2, sjw=sjw) for ps2 in SEGMENTS[kind]]


def failing(scene: Scene, bits: Bits, at: int) -> Scene:
    """The controller sends a frame in which it sees a bit error; the flag comes next."""
    scene.sends(bits, until=at)
    return scene


@shows("8.7.1")
def test_sample_point(kind: str) -> None:
    bits = lay_out(Spec(0x155, b"\x80"))
    at = bits.index("DATA", 2)
    assert bits.levels[at - 1 : at + 1] == "10"
    for scene in sample_points(kind):
        scene.sends(bits)
        scene.force("1", scene.starts[at] + scene.sample_ps + CLEAR, scene.ps2 - CLEAR)
        scene.counters(0, 0).play(received=[])
    for scene in sample_points(kind):
        scene.sends(bits, until=at)
        scene.force("1", scene.starts[at] + scene.sample_ps - scene.tq - CLEAR, scene.ps2 + scene.tq + CLEAR)
        scene.counters(8, 0).flag().between().sends(bits, ask=False).counters(7, 0).play(received=[])


def waiting(scene: Timed, id: int) -> Timed:
    """Its frame E has been disturbed; the third bit of the intermission comes next."""
    scene.e = scene.e.but(id=id)
    return scene.disturbed_sender().flag().recessive(8 + 2)


@shows("8.7.2")
def test_sof_before_the_sample_point(kind: str) -> None:
    for scene in sample_points(kind):
        waiting(scene, 0x7FF).bits("-", bit_ps=scene.sample_ps - scene.tq - CLEAR)
        scene.dominant(1).sends(scene.e, since=1, ask=False).counters(7, 0).play(received=[])


@shows("8.7.3")
def test_sof_behind_the_sample_point(kind: str) -> None:
    for id in (0x100, 0x7FF):
        for scene in sample_points(kind):
            waiting(scene, id).bits("-", bit_ps=scene.sample_ps + CLEAR)
            scene.sends(scene.e, change={0: "0"}, ask=False).counters(7, 0).play(received=[])


def early(scene: Timed, e: int) -> None:
    """A recessive identifier bit is cut short by e quanta; what the controller drives then moves by SJW at most."""
    bits = lay_out(ALTERNATING)
    at = bits.index("ID", 3)
    assert bits.levels[at : at + 2] == "10"
    early_ps = e * scene.tq - (CLEAR if e == scene.tseg2 else 0)
    moved = min(early_ps, scene.sjw * scene.tq)
    scene.sends(bits, lengths={at: -moved})
    scene.force("0", scene.starts[at + 1] + moved - early_ps, early_ps)
    scene.counters(0, 0).play(received=[])


@shows("8.7.4")
def test_early_edge_within_the_jump_width(kind: str) -> None:
    for e in range(1, Timed(kind).sjw + 1):
        early(Timed(kind), e)


@shows("8.7.5")
def test_early_edge_beyond_the_jump_width(kind: str) -> None:
    usual = Timed(kind)
    for e in range(usual.sjw + 1, usual.tseg2 + 1):
        early(Timed(kind), e)


@shows("8.7.6")
def test_one_synchronisation_a_bit(kind: str) -> None:
    bits = lay_out(ALTERNATING)
    at = bits.index("ID", 3)
    for scene in sample_points(kind, sjw=2):
        scene.sends(bits, lengths={at: -scene.tq})
        scene.force("0", scene.starts[at + 1], scene.tq).force("1", scene.starts[at + 1] + scene.tq, scene.tq)
        scene.counters(0, 0).play(received=[])


@shows("8.7.7")
def test_late_edges_of_its_own_dominant_bits(kind: str) -> None:
    bits = lay_out(ALTERNATING)
    edges = [k for k in range(1, bits.ack) if bits.levels[k - 1 : k + 1] == "10"]
    assert len(edges) > 8
    for scene in sample_points(kind, sjw=2):
        scene.sends(bits)
        for at in edges:
            scene.force("1", scene.starts[at], 2 * scene.tq)
        scene.counters(0, 0).play(received=[])


@shows("8.7.8")
def test_edge_behind_the_sample_point_of_its_recessive_bit(kind: str) -> None:
    bits = lay_out(ALTERNATING)
    at = bits.index("DATA", 2)
    assert bits.levels[at : at + 4] == "1010"
    for scene in sample_points(kind):
        scene.sends(bits, lengths={at: -scene.sjw * scene.tq})
        begin = scene.starts[at] + scene.sample_ps + CLEAR
        scene.force("0", begin, scene.starts[at + 1] - begin)
        scene.counters(0, 0).play(received=[])


@shows("8.7.9")
def test_edge_behind_the_sample_point_of_its_dominant_bit(kind: str) -> None:
    bits = lay_out(ALTERNATING)
    at = bits.index("DATA", 3)
    assert bits.levels[at] == "0"
    for scene in sample_points(kind):
        scene.sends(bits, until=at, lengths={at: -scene.sjw * scene.tq})
        scene.force("1", scene.starts[at] + scene.sample_ps - scene.tq, 2 * scene.tq)
        scene.counters(8, 0).flag().between().sends(bits, ask=False).counters(7, 0).play(received=[])


class Sent(Fast):
    """The controller sends the FD frame."""

    def whole(
        self, lengths: dict[str, int] | None = None, *, forced_ack: bool = False, ack: bool = True
    ) -> Self:
        self.ask(self.spec.but(esi=False)).sends(self.laid, ask=False)
        return self

    def valid(self) -> None:
        tec = self.iut.tec
        self.counters(max(0, tec - 1), 9).play(received=[])


def passive(kind: str) -> Sent:
    """Error passive, so that ESI is recessive."""
    scene = Sent(kind, FD.but(esi=True))
    scene.iut.preset(tec=200, rec=9)
    return scene


FD = Spec(0x155, b"\x55", fd=True)
TWO_RECESSIVE = FD.but(data=b"\x36")  # data bits 3 and 4


@shows("8.8.1.1")
def test_sample_point_at_res(kind: str) -> None:
    for scene in nominal_sample_points(kind):
        scene.whole().behind_sample("1", "res").valid()


def nominal_sample_points(kind: str) -> list[Sent]:
    return [Sent(kind, FD, ps2=ps2) for ps2 in SEGMENTS[kind]]


def data_sample_points(kind: str, spec: Spec) -> list[Sent]:
    return [Sent(kind, spec, iut=Iut(kind, NOMINAL_FD, segmented_data(ps2))) for ps2 in (1, 3, 4)]


@shows("8.8.1.2")
def test_sample_point_at_brs(kind: str) -> None:
    for scene in nominal_sample_points(kind):
        scene.whole().put("0", "BRS", 0, scene.n.tseg1).valid()


@shows("8.8.1.3")
def test_sample_point_in_the_data(kind: str) -> None:
    for scene in data_sample_points(kind, FD):
        scene.whole()
        at = scene.laid.index("DATA", 3)
        begin = scene.starts[at] + scene.fast_sample_ps + CLEAR
        scene.force("1", begin, scene.starts[at + 1] - begin).valid()
    for scene in data_sample_points(kind, FD):
        scene.whole()
        scene.force("0", scene.starts[scene.laid.index("DATA", 2)], scene.d.tseg1 * scene.tq).valid()


@shows("8.8.1.4")
def test_sample_point_at_the_crc_delimiter(kind: str) -> None:
    for scene in data_sample_points(kind, Spec(0x0AA, b"\x55", fd=True)):
        assert scene.laid.levels[scene.at("CRC DEL") - 1] == "1"
        scene.whole().put("0", "CRC DEL", 0, scene.d.tseg1)
        begin = scene.starts[scene.at("CRC DEL")] + scene.fast_sample_ps + scene.tq
        scene.force("0", begin, scene.starts[scene.laid.ack] - begin).valid()


@shows("8.8.3.1")
def test_early_edge_at_esi(kind: str) -> None:
    scene = passive(kind).whole()
    before_end(scene, scene.at("BRS"), scene.d.sjw)
    scene.put("0", "ESI", 0, scene.d.tseg1).valid()


def before_end(scene: Sent, at: int, quanta: int) -> None:
    """The last quanta of a bit dominant."""
    width = quanta * scene.tq
    scene.force("0", scene.starts[at + 1] - width, width)


@shows("8.8.3.2")
def test_early_edge_in_the_data(kind: str) -> None:
    two_recessive_bits(kind, 2, 0)


def two_recessive_bits(kind: str, quanta: int, begin: int) -> None:
    """The end of the first is dominant, and the second from a quantum up to one before its sample point."""
    scene = Sent(kind, TWO_RECESSIVE).whole()
    at = scene.laid.index("DATA", 3)
    assert (scene.laid.levels[at : at + 2], scene.laid.stuff[at]) == ("11", "")
    before_end(scene, at, quanta)
    start = scene.starts[at + 1]
    scene.force("0", start + begin * scene.tq, (scene.d.tseg1 - begin) * scene.tq).valid()


@shows("8.8.4.1")
def test_two_edges_at_esi(kind: str) -> None:
    scene = passive(kind).whole()
    before_end(scene, scene.at("BRS"), 1)
    scene.put("0", "ESI", 1, scene.d.tseg1).valid()


@shows("8.8.4.2")
def test_two_edges_in_the_data(kind: str) -> None:
    two_recessive_bits(kind, 1, 1)


@shows("8.8.5.1")
def test_late_edge_at_esi(kind: str) -> None:
    scene = Sent(kind, FD).whole()
    scene.put("1", "ESI", 0, scene.d.sjw).behind_sample("1", "ESI").valid()


@shows("8.8.5.2")
def test_late_edge_in_the_data(kind: str) -> None:
    scene = Sent(kind, FD).whole()
    at = scene.laid.index("DATA", 3)
    assert scene.laid.levels[at - 1 : at + 1] == "10"
    scene.force("1", scene.starts[at], scene.d.sjw * scene.tq)
    begin = scene.starts[at] + scene.fast_sample_ps + CLEAR
    scene.force("1", begin, scene.starts[at + 1] - begin).valid()
