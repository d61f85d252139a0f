"""What every verb does alike: its help, and what it says of words that it does not know."""

from __future__ import annotations

from contextlib import suppress

import pytest

from canwire.commands import GROUPS, VERBS, main
from tests.cases import each


@pytest.mark.smoke
@pytest.mark.parametrize("verb", sorted(VERBS))
def test_help_has_the_usage_and_examples(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main([verb, "--help"])
    shown = capsys.readouterr().out
    assert ended.value.code == 0
    assert shown.startswith(f"usage: canwire {verb} ")
    assert f"\ncanwire {verb}" in shown


@each("verb", sorted(VERBS))
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


def test_every_verb_is_in_one_group() -> None:
    assert sorted(" ".join(GROUPS.values()).split()) == sorted(VERBS)


def test_without_a_verb_it_shows_where_to_start(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    shown = capsys.readouterr()
    assert shown.err == ""
    assert len(shown.out.splitlines()) < 24  # a terminal's
    assert shown.out.index("canwire demo") < shown.out.index("canwire serve") < shown.out.index("start here")
    assert all(f"  {title} " in shown.out for title in GROUPS)


def test_help_lists_verbs_by_group(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    shown = capsys.readouterr().out
    assert all(f"\n  {verb} " in shown for verb in VERBS)
    assert shown.index("\n  serve ") < shown.index("\n  dump ") < shown.index("\n  completion ")


@each("verb", sorted(VERBS))
def test_help_begins_with_two_uses(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    """After one line of usage and one that says what it is for."""
    with pytest.raises(SystemExit):
        main([verb, "--help"])
    usage, blank, *shown = capsys.readouterr().out.splitlines()
    assert (usage.startswith(f"usage: canwire {verb} [options]"), blank) == (True, "")
    until_a_use = shown[: next(at for at, line in enumerate(shown) if line.startswith(f"canwire {verb}"))]
    assert len(until_a_use) <= 3
    assert shown[len(until_a_use) + 1].startswith("canwire ")


@pytest.mark.parametrize(("words", "said"), [
    ("play", "the following arguments are required: LOG\n"),
    ("send can0 800#11", "'800#11': identifier 800 needs more than 11 bits (000 to 7FF); write 8 hex digits"),
])  # fmt: skip
def test_what_is_missing_or_wrong_is_named_in_the_verb_s_words(
    capsys: pytest.CaptureFixture[str], words: str, said: str
) -> None:
    with suppress(SystemExit):
        assert main(words.split()) == 2
    assert said in capsys.readouterr().err
