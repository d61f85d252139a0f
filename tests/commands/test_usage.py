"""What every verb does alike: its help, and what it says of words that it does not know."""

from __future__ import annotations

import pytest

from canwire.commands import VERBS, main


@pytest.mark.smoke
@pytest.mark.parametrize("verb", sorted(VERBS))
def test_help_has_the_usage_and_examples(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main([verb, "--help"])
    shown = capsys.readouterr().out
    assert ended.value.code == 0
    assert shown.startswith(f"usage: canwire {verb} ")
    assert f"\ncanwire {verb}" in shown


@pytest.mark.parametrize("verb", sorted(VERBS))
def test_help_may_be_asked_for_in_front(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    with pytest.raises(SystemExit):
        main([verb, "--help"])
    behind = capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        main(["help", verb])
    assert ended.value.code == 0
    assert capsys.readouterr().out == behind


def test_unknown_words_show_the_usage_of_the_verb(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["dump", "--no-such-option", "can0"])
    shown = capsys.readouterr().err
    assert ended.value.code == 2
    assert shown.startswith("usage: canwire dump ")
    assert "canwire dump: error: unrecognized arguments: --no-such-option" in shown


@pytest.mark.parametrize("program", ["write", "read", "send", "mon"])
def test_candrv_programs_know_help_as_other_verbs_do(
    capsys: pytest.CaptureFixture[str], program: str
) -> None:
    main(["candrv", program, "--help"])
    shown = capsys.readouterr().out
    assert "Missing argument" not in shown
    assert "  -h       : Show this help" in shown
