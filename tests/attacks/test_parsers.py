"""No parser answers what others wrote with anything but its own errors: seeds with bytes changed, cut and joined."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import BadConfig
from canwire.boards.config.configuration import Config
from tests.attacks.parsers import PARSERS
from tests.cases import each

_SLOW = {"LDF": 10, "rows of the page": 60, "ACAN's INI": 60, "CANDRV's tables": 60}
_USUAL = 150


def changed(seeds: tuple[bytes, ...]) -> st.SearchStrategy[bytes]:
    """Bytes of one's own, or a seed of which pieces were cut out, put elsewhere, and replaced."""
    seed = st.sampled_from(seeds)
    cuts = st.tuples(st.integers(0, 400), st.integers(0, 40), st.binary(max_size=12) | seed)

    def cut(data: bytes, edits: list[tuple[int, int, bytes]]) -> bytes:
        for at, length, put in edits:
            begin = at % (len(data) + 1)
            data = data[:begin] + put + data[begin + length :]
        return data

    return st.binary(max_size=200) | st.builds(cut, seed, st.lists(cuts, min_size=1, max_size=4))


@each("name", PARSERS)
def test_it_takes_its_seeds(name: str) -> None:
    parser = PARSERS[name]
    answers = []
    for seed in parser.seeds:
        try:
            parser.run(seed)
            answers.append(True)
        except parser.refuses:
            answers.append(False)
    assert answers[0], "the first one is good"


@pytest.mark.finding("faults 9")
@pytest.mark.parametrize("name", PARSERS)
def test_it_refuses_in_its_own_words(name: str) -> None:
    parser = PARSERS[name]

    @settings(deadline=None, max_examples=_SLOW.get(name, _USUAL), database=None)
    @given(changed(parser.seeds))
    def attack(data: bytes) -> None:
        with contextlib.suppress(*parser.refuses):
            parser.run(data)

    attack()


def test_half_a_character_is_no_configuration() -> None:
    with pytest.raises(BadConfig, match="surrogates"):
        Config.parse('[[bus]]\nname = "can\udc94"\n')
