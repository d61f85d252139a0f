"""`canwire registers`: a chip's registers for people."""

from __future__ import annotations

import pytest

import canwire
from canwire.commands import main
from canwire.commands.registers import table
from canwire.values.register import RegisterValue


def test_a_table_of_registers() -> None:
    values = [RegisterValue("MOD", 0, 0x08, "AFM=single"), RegisterValue("BTR0", 6, 0x01, "SJW=1 BRP=2")]
    assert table(values, frozenset({"BTR0"})) == [
        "  0 MOD  08 00001000   AFM=single",
        "  6 BTR0 01 00000001 * SJW=1 BRP=2",
    ]


@pytest.mark.smoke
def test_of_a_board(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["registers", "inducan104", "--hub", hub_address]) == 0
    shown = capsys.readouterr().out
    assert " 31 CDR" in shown
    assert "CR" in shown.splitlines()[0]


@pytest.mark.finding("acan A15.1")
def test_a_board_that_nobody_has_set_up_is_in_basiccan_mode(
    hub_address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["registers", "inducan104", "--hub", hub_address]) == 0
    shown = capsys.readouterr().out.splitlines()
    names = [line.split()[1] for line in shown]
    assert names[:5] == ["CR", "SR", "IR", "ACR", "AMR"]
    assert {"MOD", "ECC", "TXERR"}.isdisjoint(names)
    with canwire.connect(hub_address) as hub:
        board = hub.board("inducan104").id
        with hub.open_control(board, 0) as control:
            control.initialise(canwire.LineMode(canwire.BitTiming.for_bit_rate(250_000), persistent=True))
    assert main(["registers", "inducan104", "--hub", hub_address]) == 0
    assert capsys.readouterr().out.split()[1] == "MOD"


def test_followed_only_what_changes_is_printed(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["registers", "inducan104", "--follow", "--count", "3", "--interval", "0", "--hub", hub_address]
    assert main(words) == 0
    once = capsys.readouterr().out.splitlines()
    assert len({line.split()[1] for line in once}) == len(once)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["usb-to-can"], "without registers"),
        (["inducan104", "--line", "1"], "has the lines 0 to 0"),
        (["HW999999"], "no board"),
    ],
)
def test_boards_without(
    words: list[str], complaint: str, hub_address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["registers", *words, "--hub", hub_address]) == 2
    assert complaint in capsys.readouterr().err
