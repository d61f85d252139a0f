"""ACAN identifiers and the machines in them. Source: INduCAN104 manual, "Messages identification"."""

from __future__ import annotations

import doctest

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue
from canwire.acan import BROADCAST, MachineField, acan_word, identifiers, plain_identifier
from canwire.acan.identifiers import significant
from tests.cases import each

standard, extended = st.integers(0, 0x7FF), st.integers(0, 0x1FFF_FFFF)
fields = st.integers(1, 29).flatmap(
    lambda width: st.builds(MachineField, st.integers(0, 29 - width), st.just(width))
)

# the manual's drawing: bits of the ACAN word, of an extended, of a standard identifier
DRAWING = [
    (28, 28, 10),
    (27, 27, 9),
    (21, 21, 3),
    (20, 20, 2),
    (19, 19, 1),
    (18, 18, 0),
    (17, 17, None),
    (0, 0, None),
]


@pytest.mark.conforms("AC-17")
@each(("bit", "of_extended", "of_standard"), DRAWING)
def test_bits_lie_as_drawn(bit: int, of_extended: int, of_standard: int | None) -> None:
    assert acan_word(1 << of_extended, extended=True) == 1 << bit
    if of_standard is not None:
        assert acan_word(1 << of_standard) == 1 << bit
    else:
        assert plain_identifier(1 << bit) == 0


@pytest.mark.conforms("AC-17")
@given(standard, extended)
def test_round_trip(short: int, long: int) -> None:
    assert plain_identifier(acan_word(short)) == short
    assert plain_identifier(acan_word(long, True), True) == long


@pytest.mark.conforms("AC-17")
@given(st.integers(0, 0xFFFF_FFFF))
def test_bits_that_mean_nothing_are_cleared(word: int) -> None:
    assert significant(word) == word & 0x1FFC_0000
    assert significant(word, extended=True) == word & 0x1FFF_FFFF


@each(("identifier", "is_extended"), [(0x800, False), (-1, False), (1 << 29, True), ("1", True)])
def test_impossible_identifiers_are_refused(identifier: int, is_extended: bool) -> None:
    with pytest.raises(BadValue, match="identifier"):
        acan_word(identifier, is_extended)


@pytest.mark.conforms("AC-18")
def test_the_manuals_example_names_machines_1_to_7_in_bits_20_to_18() -> None:
    field = MachineField()
    assert field.mask == 0b111 << 18
    assert list(field.machines) == [1, 2, 3, 4, 5, 6, 7]
    assert acan_word(0b00001001_101) == field.sent_to(acan_word(0b00001001_000), 5)
    assert field.destination(acan_word(0b00001001_101)) == 5
    assert field.destination(0b101 << 18) == field.destination(acan_word(0b101 << 18, True)) == 5


@pytest.mark.conforms("AC-18")
@given(fields, extended, st.data())
def test_a_message_goes_to_one_machine_or_to_all(field: MachineField, word: int, data: st.DataObject) -> None:
    machine, other = data.draw(st.sampled_from(field.machines)), data.draw(st.sampled_from(field.machines))
    sent = field.sent_to(word, machine)
    assert sent & ~field.mask == word & ~field.mask
    assert field.destination(sent) == machine
    assert field.concerns(sent, machine)
    assert field.concerns(sent, other) == (machine == other)
    assert field.concerns(field.sent_to(word, BROADCAST), other)
    assert field.word(BROADCAST) == 0
    assert field.word(machine) & ~field.mask == 0


@pytest.mark.conforms("AC-18")
@each(("position", "width"), [(-1, 3), (0, 0), (27, 3), (0, 30)])
def test_a_field_lies_within_the_identifier(position: int, width: int) -> None:
    with pytest.raises(BadValue, match="MID"):
        MachineField(position, width)


@each("machine", [-1, 8, 1.0])
def test_a_machine_fits_the_field(machine: int) -> None:
    with pytest.raises(BadValue, match="machine"):
        MachineField().word(machine)


def test_docstrings() -> None:
    result = doctest.testmod(identifiers)
    assert result.attempted
    assert not result.failed
