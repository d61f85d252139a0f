"""python-can programs as people write them, in virtual time: they do not hang, and do the same every time."""

from __future__ import annotations

import functools

import pytest

import canwire
from canwire import Hub
from tests.cases import each

can = pytest.importorskip("can")

from tests.threads.shapes import REQUESTS, SHAPES, play  # noqa: E402  (python-can is an extra)

pytestmark = [pytest.mark.conforms("N-61"), pytest.mark.finding("first-hour 1"), pytest.mark.timeout(60)]


@pytest.mark.parametrize("name", SHAPES)
def test_two_ecus_answer_in_a_hubs_virtual_time(name: str, canwire_hub: Hub) -> None:
    log = play(name, lambda: can.Bus("can0", interface="canwire", hub=canwire_hub))
    for number in range(REQUESTS):
        for ecu in (2, 3):
            assert any(line.split()[1] == f"{0x110 * ecu + number:X}" for line in log[:-1]), log
    assert float(log[-1]) < 3


@each("name", SHAPES)
def test_the_same_bytes_every_time(name: str) -> None:
    assert in_a_hub(name) == in_a_hub(name)


def in_a_hub(name: str) -> list[str]:
    with canwire.connect(time="virtual") as hub, canwire.in_time(hub):
        return play(name, functools.partial(can.Bus, "can0", interface="canwire", hub=hub))


@each("name", SHAPES)
def test_a_lab_gives_the_same_log_as_a_hub(name: str) -> None:
    with canwire.Lab() as lab, canwire.in_time(lab):
        log = play(name, functools.partial(can.Bus, interface="canwire", channel=lab.can_bus("can0")))
    assert log == in_a_hub(name)
