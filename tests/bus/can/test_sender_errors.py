"""A sender that reads another level than it drives: which kind of error that is, and whether it counts."""

from __future__ import annotations

import pytest

from canwire import Frame, Lab, LabBus
from canwire.bus.can import station as states
from canwire.bus.can.bit_layout import FIELDS, BitLayout
from canwire.bus.can.node import NO_RULE, TRANSMIT_ERROR
from canwire.bus.can.station import Station
from canwire.bus.can.tally import Tally
from tests.bus.can.test_around_frames import Recorder, offered
from tests.cases import each

pytestmark = pytest.mark.core

STUFF, FORM, BIT = 1, 2, 4


class Teller(Recorder):
    """Also writes down the rule."""

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        self.told.append((kind, bit, rule))


def sent_but_for(frame: Frame, disturbed: int) -> tuple[Teller, Station]:
    """A sender at the sample of this bit of its frame, which it reads inverted."""
    node = Teller()
    node.offer = offered(frame)
    station = Station(node, Tally())
    for k in range(disturbed + 1):
        station.begin_bit()
        station.sample(station.out ^ 1 if k == disturbed else station.out)
    return node, station


def stuff_bit_before(frame: Frame, field: str, level: int) -> int:
    """The stuff bit of this level behind which the first bit of the field stands; -1 if there is none."""
    layout = BitLayout(frame)
    at = layout.find(field) - 1
    return at if layout.stuffed[at] and layout.levels[at] == level else -1


def some_frame_with_stuff_bit(field: str, level: int, *, extended: bool = False) -> tuple[Frame, int]:
    """The first identifier whose data frame of one byte, or remote frame, has it."""
    for id in range(1 << 11):
        for remote in (False, True):
            frame = Frame(
                id << 18 | id if extended else id,
                b"" if remote else b"\x55",
                extended=extended,
                remote=remote,
            )
            at = stuff_bit_before(frame, field, level)
            if at >= 0:
                return frame, at
    raise AssertionError(f"no stuff bit {level} before {field}")


@pytest.mark.finding("wire B")
@pytest.mark.parametrize("level", [0, 1])
def test_the_stuff_bit_behind_the_crc_belongs_to_the_crc(level: int) -> None:
    frame, at = some_frame_with_stuff_bit("CRC DEL", level)
    assert FIELDS[BitLayout(frame).fields[at]] == "CRC"
    node, _ = sent_but_for(frame, at)
    assert node.told == [(BIT, at, TRANSMIT_ERROR)]
    assert node.segment == 0x18  # as the silicon's ECC has it: it looks for the CRC delimiter already


def test_behind_it_the_crc_delimiter_is_of_fixed_form() -> None:
    frame, at = some_frame_with_stuff_bit("CRC DEL", 0)
    node, _ = sent_but_for(frame, at + 1)
    assert node.told == [(FORM, at + 1, TRANSMIT_ERROR)]


def test_a_recessive_stuff_bit_behind_rtr_is_no_part_of_arbitration() -> None:
    """Rule 3's exception ends before RTR: the counter goes up."""
    frame, at = some_frame_with_stuff_bit("IDE", 1)
    node, station = sent_but_for(frame, at)
    assert node.told == [(BIT, at, TRANSMIT_ERROR)]
    assert station.state == states.ACTIVE_FLAG


@each(("field", "extended"), [("RTR", False), ("RTR", True), ("RTR2", True)])
def test_a_recessive_stuff_bit_in_arbitration_is_spared(field: str, extended: bool) -> None:
    frame, at = some_frame_with_stuff_bit(field, 1, extended=extended)
    node, _ = sent_but_for(frame, at)
    assert node.told == [(STUFF, at, NO_RULE)]


@pytest.mark.parametrize("bitwise", [False, True])
def test_an_error_in_the_delimiter_behind_it_costs_no_second_frame(
    lab: Lab, can_bus: LabBus, bitwise: bool
) -> None:
    """A single shot is given up at its own error; the next one waits in the same mailbox by then."""
    can_bus.wire.bitwise = bitwise
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.flip(bit="dlc", seen_by="sender")
    can_bus.faults.hold("dominant", at=can_bus.faults.place("error delimiter", 4))
    for id in (0x100, 0x101):
        a.send(Frame(id), single_shot=True)
    lab.run_until_idle()
    assert (a.aborted, [frame.id for frame in b.receive_many(9)]) == (1, [0x101])
