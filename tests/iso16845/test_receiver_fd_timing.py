"""ISO 16845-1, 7.8: bit timing of a receiver, FD frames."""

from __future__ import annotations

from typing import Self

from tests.iso16845.frames import Bits, Spec, lay_out
from tests.iso16845.iut import Iut, segmented
from tests.iso16845.purposes import shows
from tests.iso16845.scenes import Scene
from tests.iso16845.test_receiver_timing import CLEAR

FD = Spec(0x155, b"\x55", fd=True)
D7 = Spec(0x155, b"\x7f", fd=True)  # data bit 7 is a dominant stuff bit
LAST_CRC_RECESSIVE, LAST_CRC_DOMINANT = Spec(0x032, b"\x55", fd=True), Spec(0x032, b"\x49", fd=True)


class Fast(Scene):
    """One FD frame with fine disturbances; quanta of both phases have the same length."""

    def __init__(
        self, kind: str, spec: Spec, *, ps2: int = 10, sjw_n: int = 4, iut: Iut | None = None
    ) -> None:
        super().__init__(kind, True, rec=9, iut=iut or Iut(kind, segmented(kind, ps2, sjw_n)))
        assert self.iut.timing.quantum_ps == self.iut.data.quantum_ps
        self.spec = spec
        self.laid = lay_out(spec)
        self.n, self.d = self.iut.timing, self.iut.data

    def whole(
        self, lengths: dict[str, int] | None = None, *, forced_ack: bool = False, ack: bool = True
    ) -> Self:
        """The whole frame; some bits are so many quanta longer or shorter."""
        changed = {self.at(name): quanta * self.tq for name, quanta in (lengths or {}).items()}
        change = {self.laid.ack: "0"} if forced_ack else {}
        self.lt(self.laid, lengths=changed, change=change, ack=ack)
        return self

    def until(self, name: str) -> Self:
        """The frame up to this bit, where the controller sees an error."""
        self.lt(self.laid, until=self.at(name))
        return self

    def at(self, name: str) -> int:
        """A bit by its field's name, or "stuff", the stuff bit in the data, and "before" it."""
        if name in ("stuff", "before"):
            at = self.laid.index("DATA", 7)
            assert self.laid.stuff[at] == "dynamic"
            return at - (name == "before")
        return self.laid.names.index(name)

    def put(self, level: str, name: str, begin: float, end: float, *, clear: int = 0) -> Self:
        """Force a level between two quanta of a bit, beginning `clear` ps later."""
        start = self.starts[self.at(name)]
        begin_ps = start + round(begin * self.tq) + clear
        self.force(level, begin_ps, start + round(end * self.tq) - begin_ps)
        return self

    def behind_sample(self, level: str, name: str, *, late: int = 0) -> Self:
        """Force a level from the sample point (and `late` quanta) to the end of the bit."""
        at = self.at(name)
        start, end = self.starts[at], self.starts[at + 1]
        fast = self.laid.fast[at]
        begin = (
            start
            + (self.fast_sample_ps if fast else self.sample_ps)
            + late * self.tq
            + (0 if late else CLEAR)
        )
        self.force(level, begin, end - begin)
        return self

    def valid(self) -> None:
        """The frame has been received: no flag, REC one less."""
        self.counters(0, 8).play(received=[self.spec])

    def flagged(self) -> None:
        """An error: the flag comes now."""
        self.flag().between().counters(rec=None, tec=0).play(received=[])


def last_bit(bits: Bits) -> str:
    return bits.levels[bits.index("CRC DEL") - 1]


@shows("7.8.1.1")
def test_sample_point_at_brs(kind: str) -> None:
    scene = Fast(kind, FD).whole()
    scene.put("0", "BRS", 0, scene.n.tseg1).valid()
    scene = Fast(kind, FD.but(brs=False)).whole()
    scene.behind_sample("1", "BRS").valid()


@shows("7.8.1.2")
def test_sample_point_in_the_data(kind: str) -> None:
    scene = Fast(kind, FD).whole()
    second = scene.laid.index("DATA", 2)
    assert scene.laid.levels[second] == "1"
    scene.force("0", scene.starts[second], scene.d.tseg1 * scene.tq).valid()
    scene = Fast(kind, FD.but(data=b"\x15")).whole()
    second = scene.laid.index("DATA", 2)
    assert scene.laid.levels[second] == "0"
    begin = scene.starts[second] + scene.fast_sample_ps + CLEAR
    scene.force("1", begin, scene.starts[second + 1] - begin).valid()


@shows("7.8.1.3")
def test_sample_point_at_the_crc_delimiter(kind: str) -> None:
    scene = Fast(kind, FD).whole()
    scene.put("0", "CRC DEL", 0, scene.d.tseg1).valid()
    scene = Fast(kind, FD).until("CRC DEL")
    scene.put("0", "CRC DEL", 0, scene.d.tseg1 + 1.1).flagged()


@shows("7.8.2.1")
def test_late_edge_at_res(kind: str) -> None:
    for e in range(5, 30):
        scene = Fast(kind, FD).whole({"FDF": e})
        scene.put("0", "BRS", 0, scene.n.tseg1).valid()


@shows("7.8.2.2")
def test_early_edge_at_res(kind: str) -> None:
    scene = Fast(kind, FD.but(brs=False, esi=True), sjw_n=1)
    shorter = CLEAR - scene.ps2
    scene.lt(scene.laid, lengths={scene.at("FDF"): shorter})
    scene.behind_sample("1", "BRS").valid()


@shows("7.8.3.1")
def test_late_edge_at_esi_within_the_jump_width(kind: str) -> None:
    for e in (1, 2):
        scene = Fast(kind, FD.but(esi=True)).whole({"ESI": e})
        scene.put("0", "ESI", e, e + scene.d.tseg1).valid()


@shows("7.8.3.2")
def test_late_edge_in_the_data_within_the_jump_width(kind: str) -> None:
    for e in (1, 2):
        scene = Fast(kind, D7).until("stuff")
        scene.put("1", "stuff", 0, e).put("1", "stuff", scene.d.tseg1 + e, 20)
        scene.skip(e * scene.tq).flagged()


@shows("7.8.3.3")
def test_late_edge_at_the_crc_delimiter_within_the_jump_width(kind: str) -> None:
    for e in (1, 2):
        late_at_the_crc_delimiter(kind, e, e)


def late_at_the_crc_delimiter(kind: str, e: int, corrected: int) -> None:
    """The edge comes e quanta late; the controller is so much later from then on."""
    scene = Fast(kind, LAST_CRC_RECESSIVE).whole(ack=False)
    assert last_bit(scene.laid) == "1"
    scene.put("0", "CRC DEL", e, scene.d.tseg1 + corrected)
    scene.drives(scene.starts[scene.laid.ack] + corrected * scene.tq, scene.n_ps).valid()


@shows("7.8.4.1")
def test_late_edge_at_esi_beyond_the_jump_width(kind: str) -> None:
    for e in range(3, 7):
        scene = Fast(kind, FD.but(esi=True)).whole()
        scene.put("0", "ESI", e, scene.d.tseg1 + scene.d.sjw).valid()


@shows("7.8.4.2")
def test_late_edge_in_the_data_beyond_the_jump_width(kind: str) -> None:
    for e in range(3, 7):
        scene = Fast(kind, D7).until("stuff")
        scene.put("1", "stuff", 0, e).put("1", "stuff", scene.d.tseg1 + scene.d.sjw, 20)
        scene.skip(scene.d.sjw * scene.tq).flagged()


@shows("7.8.4.3")
def test_late_edge_at_the_crc_delimiter_beyond_the_jump_width(kind: str) -> None:
    for e in range(3, 7):
        late_at_the_crc_delimiter(kind, e, 2)


@shows("7.8.5.1")
def test_early_edge_at_esi_within_the_jump_width(kind: str) -> None:
    for e in (1, 2):
        Fast(kind, FD).whole({"BRS": -e}).behind_sample("1", "ESI", late=e).valid()


@shows("7.8.5.2")
def test_early_edge_in_the_data_within_the_jump_width(kind: str) -> None:
    for e in (1, 2):
        Fast(kind, D7).whole({"before": -e}).behind_sample("1", "stuff").valid()


@shows("7.8.5.3")
def test_early_edge_at_the_ack_slot_within_the_jump_width(kind: str) -> None:
    for e in range(1, 5):
        Fast(kind, FD).whole({"CRC DEL": -e}, forced_ack=True).behind_sample("1", "ACK").valid()


@shows("7.8.6.1")
def test_early_edge_at_esi_beyond_the_jump_width(kind: str) -> None:
    scene = Fast(kind, FD).whole()
    scene.behind_sample("0", "BRS", late=0).behind_sample("1", "ESI")
    assert scene.d.tseg2 == scene.d.sjw + 1  # so that this is e = 3, all of PS2
    scene.valid()


@shows("7.8.6.2")
def test_early_edge_in_the_data_beyond_the_jump_width(kind: str) -> None:
    Fast(kind, D7).whole().behind_sample("0", "before").behind_sample("1", "stuff").valid()


@shows("7.8.6.3")
def test_early_edge_at_the_ack_slot_beyond_the_jump_width(kind: str) -> None:
    for e in range(5, 11):
        scene = Fast(kind, FD).whole(ack=False)
        slot = scene.starts[scene.laid.ack]
        clear = CLEAR if e == 10 else 0
        scene.force("0", slot - e * scene.tq + clear, e * scene.tq - clear + scene.sample_ps)
        scene.behind_sample("1", "ACK")
        scene.drives(slot - scene.n.sjw * scene.tq, scene.n_ps).valid()


@shows("7.8.7.1")
def test_one_synchronisation_at_res(kind: str) -> None:
    Fast(kind, FD).whole().put("1", "res", 1, 2).behind_sample("1", "res").valid()


@shows("7.8.7.2")
def test_one_synchronisation_in_the_data(kind: str) -> None:
    Fast(kind, D7).whole().put("1", "stuff", 1, 2).behind_sample("1", "stuff").valid()


@shows("7.8.7.3")
def test_one_synchronisation_at_the_ack_slot(kind: str) -> None:
    Fast(kind, FD).whole(forced_ack=True).put("1", "ACK", 1, 2).behind_sample("1", "ACK").valid()


@shows("7.8.8.1")
def test_one_synchronisation_behind_an_early_edge_at_esi(kind: str) -> None:
    Fast(kind, FD).whole({"BRS": -1}).put("1", "ESI", 1, 2).behind_sample("1", "ESI").valid()


@shows("7.8.8.2")
def test_one_synchronisation_behind_an_early_edge_in_the_data(kind: str) -> None:
    Fast(kind, D7).whole({"before": -1}).put("1", "stuff", 1, 2).behind_sample("1", "stuff").valid()


@shows("7.8.8.3")
def test_one_synchronisation_behind_an_early_edge_at_the_ack_slot(kind: str) -> None:
    scene = Fast(kind, FD).whole({"CRC DEL": -1}, forced_ack=True)
    scene.put("1", "ACK", 1, 2).behind_sample("1", "ACK").valid()


@shows("7.8.9.1")
def test_no_synchronisation_behind_a_dominant_sample_at_brs(kind: str) -> None:
    Fast(kind, FD.but(brs=False)).whole().put("1", "BRS", 0, 2).behind_sample("1", "BRS").valid()


@shows("7.8.9.2")
def test_no_synchronisation_behind_a_dominant_sample_in_the_data(kind: str) -> None:
    scene = Fast(kind, FD.but(data=b"\x80")).until("stuff")
    assert scene.laid.levels[scene.at("stuff")] == "1"
    scene.put("0", "stuff", 1, scene.d.tseg1 + 1.1).flagged()


@shows("7.8.9.3")
def test_no_synchronisation_behind_a_dominant_sample_at_the_crc_delimiter(kind: str) -> None:
    scene = Fast(kind, LAST_CRC_DOMINANT).until("CRC DEL")
    assert last_bit(scene.laid) == "0"
    scene.put("0", "CRC DEL", 1, scene.d.tseg1 + 1.1).flagged()
