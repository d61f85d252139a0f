"""No parser answers what others wrote with anything but its own errors: seeds with bytes changed, cut and joined."""

from __future__ import annotations

import contextlib
import sys
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import BadConfig
from canwire.boards.config.configuration import Config
from tests import warm
from tests.attacks.parsers import PARSERS
from tests.cases import each

_SLOW = {"LDF": 10, "rows of the page": 60, "ACAN's INI": 60, "CANDRV's tables": 60}
_USUAL = 150
_EDIT = 2 + 1 + 1 + 1 + 12  # where, how much is cut out, how much put in, of what kind, and bytes for it
_PLAN = 1 + 4 * _EDIT


def changed(seeds: tuple[bytes, ...]) -> st.SearchStrategy[bytes]:
    """Bytes of one's own, or a seed of which pieces were cut out, put elsewhere, and replaced."""
    plan = st.binary(min_size=_PLAN, max_size=_PLAN)  # one draw, not some twenty: those took most of the time
    return st.binary(max_size=200) | st.builds(partial(cut, seeds), st.sampled_from(seeds), plan)


def cut(seeds: tuple[bytes, ...], data: bytes, plan: bytes) -> bytes:
    """One to four pieces of the data replaced, as the plan says; one of zeros changes nothing."""
    for edit in range(1 + plan[0] % 4):
        piece = plan[1 + edit * _EDIT :][:_EDIT]
        begin = int.from_bytes(piece[:2]) % 401 % (len(data) + 1)
        put, kind = piece[5 : 5 + piece[3] % 13], piece[4] % 4
        if kind == 2:
            put = bytes(value & 0x7F for value in put)  # else few texts get past their decoding
        elif kind == 3:
            put = seeds[piece[3] % len(seeds)]
        data = data[:begin] + put + data[begin + piece[2] % 41 :]
    return data


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


def test_their_files_go_with_the_process_that_has_them() -> None:
    """Each run had left some in memory: sixteen hundred in a day."""
    program = "from tests.attacks.parsers import scratch; print(scratch('.txt').parent)"
    root = Path(__file__).parents[2]
    done = warm.run([sys.executable, "-c", program], cwd=root, capture_output=True, text=True, check=True)
    assert "canwire-parsers-" in done.stdout
    assert not Path(done.stdout.strip()).exists()


def test_half_a_character_is_no_configuration() -> None:
    with pytest.raises(BadConfig, match="surrogates"):
        Config.parse('[[bus]]\nname = "can\udc94"\n')
