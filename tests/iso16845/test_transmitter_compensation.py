"""ISO 16845-1, 8.8.2: delay compensation of a transmitter."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Self

import pytest

from canwire import ControllerOptions, DelayCompensation
from tests.bus.can.reference_bits import opposite
from tests.iso16845.frames import Spec
from tests.iso16845.iut import DATA, Iut
from tests.iso16845.purposes import shows
from tests.iso16845.test_receiver_timing import CLEAR
from tests.iso16845.test_transmitter_timing import FD, Sent


class Compensating(Sent):
    """The sender reads itself one or two data bits late, and knows by how much; its own bits begin as ever."""

    def __init__(self, kind: str, spec: Spec, delay_bits: int, *, measured: bool, early: int) -> None:
        self.delay_ps = delay_bits * DATA.bit_time_ps
        offset_ps = DATA.sample_time_ps - early * DATA.quantum_ps
        self.second_ps = self.delay_ps + offset_ps
        fixed_ns = (offset_ps if measured else self.second_ps) / 1000
        options = ControllerOptions(
            loop_delay_ns=self.delay_ps / 1000, compensation=DelayCompensation(fixed_ns, measured=measured)
        )
        super().__init__(kind, spec, iut=Iut(kind, options=options))
        assert self.sample_ps > self.delay_ps

    def read(self, level: str, at: int, begin_ps: int, end_ps: int) -> Self:
        """Force a level from and to a time behind the start of a bit that it sends."""
        return self.force(level, self.starts[at] + begin_ps, end_ps - begin_ps)


def compensating(kind: str, spec: Spec, *, early: int = 0) -> Iterator[Compensating]:
    """Delays of one and two bits, compensated each way; the second sample point some quanta early."""
    for delay_bits in (1, 2):
        for measured in (True, False):
            yield Compensating(kind, spec, delay_bits, measured=measured, early=early)


@shows("8.8.2.1")
def test_no_second_sample_point_at_res(kind: str) -> None:
    for scene in compensating(kind, FD):
        scene.whole().behind_sample("1", "res").valid()


@shows("8.8.2.2")
def test_no_second_sample_point_at_brs(kind: str) -> None:
    for scene in compensating(kind, FD):
        brs = scene.at("BRS")
        scene.ask(FD).sends(scene.laid, until=brs, ask=False)
        scene.read("0", brs, scene.delay_ps, scene.sample_ps + CLEAR)
        scene.flag().between().sends(scene.laid, ask=False).counters(7, 9).play(received=[])


@shows("8.8.2.3")
def test_second_sample_point_in_the_data(kind: str) -> None:
    for scene in compensating(kind, FD):
        scene.whole()
        at = scene.laid.index("DATA", 3)
        assert scene.laid.levels[at] == "0"
        scene.read("1", at, scene.second_ps + scene.tq, scene.delay_ps + scene.d_ps).valid()
    for scene in compensating(kind, FD):
        scene.whole()
        at = scene.laid.index("DATA", 2)
        assert scene.laid.levels[at] == "1"
        scene.read("0", at, scene.delay_ps, scene.second_ps - scene.tq).valid()


@shows("8.8.2.4")
def test_last_second_sample_point(kind: str) -> None:
    for scene in compensating(kind, FD, early=2):
        scene.whole()
        delimiter = scene.at("CRC DEL")
        at = delimiter - scene.delay_ps // scene.d_ps
        assert scene.starts[at] + scene.second_ps < scene.starts[delimiter] + scene.fast_sample_ps
        wrong = opposite(scene.laid.levels[at])
        scene.read(wrong, at, scene.delay_ps, scene.second_ps - scene.tq)
        scene.read(wrong, at, scene.second_ps + scene.tq, scene.delay_ps + scene.d_ps).valid()


@pytest.mark.parametrize("quanta", [-1, 1])
def test_what_is_wrong_at_the_second_sample_point_is_an_error_at_the_next_ordinary_one(quanta: int) -> None:
    """The same disturbances as above, but over the second sample point."""
    for scene in compensating("fd", FD):
        at = scene.laid.index("DATA", 3)
        late_ps = scene.second_ps - scene.fast_sample_ps
        reported = at + -(-late_ps // scene.d_ps)
        scene.ask(FD).sends(scene.laid, until=reported, ask=False)
        middle = scene.second_ps + quanta * scene.tq // 2
        scene.read("1", at, middle - scene.tq, middle + scene.tq)
        scene.flag().between().sends(scene.laid, ask=False).counters(7, 9).play(received=[])
