"""Command lines of the ACAN tools, as MS-DOS wrote them: /C:16000 /R:250 /I 1 2; switches in either case."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import NamedTuple

from canwire import BadValue

CLOCK_KHZ, RATE_KBPS = 16_000, 250  # the board's oscillator; what the tools start the bus with
MID_MAX = 7


class Words(NamedTuple):
    """What stood there: values of switches by their capital letter ("" without a colon), and the rest."""

    switches: Mapping[str, str]
    rest: tuple[str, ...]

    def number(self, letter: str, usual: int, base: int = 10) -> int:
        """The number of a word such as /C:16000; raises BadValue."""
        text = self.switches.get(letter)
        if text is None:
            return usual
        try:
            return int(text, base)
        except ValueError:
            raise BadValue(f"/{letter}:{text}: {'hexadecimal' if base == 16 else 'decimal'} digits") from None


def parsed(words: Collection[str], with_value: str, without: str = "") -> Words:
    """Switches of these letters, several may stand in one word: /P:280/I:5. Raises BadValue for any other."""
    switches: dict[str, str] = {}
    rest = []
    for word in words:
        if not word.startswith("/"):
            rest.append(word)
            continue
        for switch in re.findall("/[^/]*", word):
            letter, colon, value = switch[1:2].upper(), switch[2:3], switch[3:]
            known = letter in with_value if colon == ":" and value else letter in without and not colon
            if not letter or not known:
                there = ", ".join([f"/{one}:..." for one in with_value] + [f"/{one}" for one in without])
                raise BadValue(f"{switch}: there are {there}")
            switches[letter] = value
    return Words(switches, tuple(rest))


def machine(text: str, what: str) -> int:
    """A machine number (MID), 0 to 7; raises BadValue."""
    if not re.fullmatch(f"[0-{MID_MAX}]", text.strip()):
        raise BadValue(f"{what} {text!r}: a machine's number is 0 to {MID_MAX}")
    return int(text)
