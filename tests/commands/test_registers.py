"""`canwire registers`: a chip's registers for people."""

from __future__ import annotations

import pytest

from canwire.commands import main
from canwire.commands.registers import table
from canwire.values.register import RegisterValue


def test_a_table_of_registers() -> None:
    values = [RegisterValue("MOD", 0, 0x08, "AFM=single"), RegisterValue("BTR0", 6, 0x01, "SJW=1 BRP=2")]
    assert table(values, frozenset({"BTR0"})) == [
        "  0 MOD  08 00001000   AFM=single",
        "  6 BTR0 01 00000001 * SJW=1 BRP=2",
    ]


def test_of_a_board(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["registers", "inducan104", "--hub", hub_address]) == 0
    shown = capsys.readouterr().out
    assert " 31 CDR" in shown
    assert "MOD" in shown.splitlines()[0]


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
