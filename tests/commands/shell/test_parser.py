"""Mistakes in the words of a command show the usage of the verb they were made in, at any depth."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pytest

from canwire.commands import VERBS, _load, main
from canwire.commands.shell.parser import Parser
from tests.cases import each

pytestmark = pytest.mark.finding("newcomer F13")

OWN_SWITCHES = {"candrv write", "candrv read", "candrv send", "candrv mon"}  # as the manual has them


def deepest() -> Iterator[str]:
    """Every verb and sub-verb that has no verbs below it."""
    for name, verb in VERBS.items():
        parser = Parser(prog=name)
        _load(verb, parser)
        yield from leaves(name, parser)


def leaves(name: str, parser: argparse.ArgumentParser) -> Iterator[str]:
    """`fault BUS babble`: what has to stand before a sub-verb stands here by its name."""
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    before = "".join(
        f" {each.metavar}" for each in parser._actions if not (each.option_strings or each in below)
    )
    for action in below:
        for word, sub in action.choices.items():
            yield from leaves(f"{name}{before} {word}", sub)
    if not below:
        yield name


PASSES_ON = {"run"}  # everything behind its own options, to the program
LEAVES = sorted(set(deepest()) - OWN_SWITCHES)


def test_the_table_has_sub_verbs_too() -> None:
    assert {"dump", "lin dump", "candrv registry set", "acan spy", "fault BUS flip"} <= set(LEAVES)


@each("verb", LEAVES)
def test_an_unknown_option_shows_the_usage_of_its_verb(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    more = [] if verb in PASSES_ON else ["1"] * 6
    with pytest.raises(SystemExit) as ended:
        main([*verb.split(), *more, "--no-such-option"])
    shown = capsys.readouterr().err
    assert ended.value.code == 2
    assert shown.startswith(f"usage: canwire {verb} ")
    assert f"canwire {verb}: error: " in shown


@each("verb", LEAVES)
def test_help_of_every_verb_begins_with_its_usage(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*verb.split(), "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: canwire {verb} ")


@pytest.mark.parametrize("verb", sorted(OWN_SWITCHES))
def test_the_manual_s_programs_show_theirs(capsys: pytest.CaptureFixture[str], verb: str) -> None:
    assert main([*verb.split(), "-x", "1"]) == 2
    shown = capsys.readouterr().out.splitlines()
    assert shown[1] == "Unknown option -x"
    assert shown[2].startswith("Can")


@pytest.mark.parametrize(("words", "said"), [
    ("serve --time virtual", "virtual: programs that share a hub wait for each other by the clock; real or fast"),
    ("play log --time fast", "argument --time: fast: a private bus is virtual, or follows the clock; virtual or real"),
    ("demo --time fast", "argument --time: fast: a private bus is virtual, or follows the clock; virtual or real"),
    ("demo --time quick", "argument --time: 'quick': virtual or real"),
])  # fmt: skip
def test_time_has_the_same_names_everywhere(
    capsys: pytest.CaptureFixture[str], words: str, said: str
) -> None:
    with pytest.raises(SystemExit):
        main(words.split())
    assert said in capsys.readouterr().err
