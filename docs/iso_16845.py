"""Writes docs/iso-16845.md: every public test purpose of ISO 16845-1, and what it says of each of our controllers.

    python docs/iso_16845.py

Purposes and reasons come from tests/iso16845/purposes.py, the tests that show them from their `shows` decorators. A
purpose passes where a test shows it that is not listed as open: the suite itself has to be green, and what is listed as
open has to fail.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.iso16845.purposes import KINDS, OPEN, PURPOSES, VARIANTS, why_not  # noqa: E402

PAGE = ROOT / "docs" / "iso-16845.md"
TESTS = ROOT / "tests" / "iso16845"
CHAPTERS = {
    "7.1": "Receiver: valid frames",
    "7.2": "Receiver: errors",
    "7.3": "Receiver: active error frames",
    "7.4": "Receiver: overload frames",
    "7.5": "Receiver: passive state",
    "7.6": "Receiver: error counters",
    "7.7": "Receiver: bit timing, classic frames",
    "7.8": "Receiver: bit timing, FD frames",
    "8.1": "Transmitter: valid frames",
    "8.2": "Transmitter: errors",
    "8.3": "Transmitter: active error frames",
    "8.4": "Transmitter: overload frames",
    "8.5": "Transmitter: passive state and bus-off",
    "8.6": "Transmitter: error counters",
    "8.7": "Transmitter: bit timing, classic frames",
    "8.8": "Transmitter: bit timing, FD frames",
    "9.6": "Both error counters",
}
HEAD = """# ISO 16845-1

Written by `python docs/iso_16845.py` from `tests/iso16845`: change that, not this page.

ISO 16845-1 says how a CAN controller's data link layer is tested. Each row is one of its purposes, in our own words,
and what our test of it says of each controller: a lower tester puts levels in front of the controller's receiver,
picosecond by picosecond, and every level that the controller drives is held against what it must drive, and its
counters and what it hands up besides (`tests/iso16845/tester.py`). `tests/iso16845/rows` has setup, disturbance and
expected response of each row.

Numbers follow ISO 16845-1. {standard} of the {total} rows are purposes of the standard, as far as they are known in
public; the other {variants} ({names}) are variants that a public list added:
the same errors with a passive controller, or one in restricted operation. The standard has more to it: other chapters,
and a part 2.

An FD controller runs a purpose with classic frames and once more with FD frames.

| | {heads} |
|---|{rules}|
{summary}

## Where the standard can be read in two ways

**How long an FD acknowledge is.** The ACK slot of an FD frame is one bit here, and a second dominant one is tolerated,
as in Bosch's CAN FD 1.0 and the tools of Linux. A reading of two bits always makes what follows come one bit later.
Rows count from their field, and so hold either way, but for one place:

**Where the flag of a CRC error begins in an FD frame** (7.2.5, 7.6.10). ISO 11898-1:2015 has it begin in the bit behind
the ACK delimiter. With an ACK slot of one bit that is the third bit behind the CRC delimiter, and with one of two bits
the fourth, which is what public test descriptions say. Ours is the bit behind the ACK delimiter: the third, or the
fourth where the acknowledge took two bits. An acknowledgement error comes in the third bit in both readings: a sender
waits for a late acknowledge.

## The long run

Beside the standard's purposes stands a second opinion: a slow reference, written from the rules alone
(`tests/bus/can/reference`), on which random schedules of frames, starts, stops and faults are played as on the bus:
bit by bit, in whole frames and changing between both.
`python -m tests.bus.can.reference.long_run` plays as many as one likes. In November 2026:

| seeds | frames | faults | errors told | state changes | arbitrations lost | schedules that differ |
|---|---|---|---|---|---|---|
| 0 to 27,039 | 1,000,676 | 102,575 | 326,429 | 44,360 | 945,627 | 6 |
| 27,040 to 44,299, after the repairs | 638,524 | 65,053 | 210,262 | 28,684 | 602,874 | 4 |
| 44,300 to 71,419, after the last of them | 1,002,228 | 103,141 | 330,921 | 43,814 | 949,009 | 0 |

The ten were four things, mended, and their schedules are part of the short run in CI:

- A passive sender whose missing acknowledge was spared (rule 3, exception A) went on to count 8 for a dominant bit in a
  later flag.
- A suspended node began a quarter of a bit early if all others came to rest at the sample point of its last suspended
  bit.
- A frame offered in an idle bit that had begun with a glitch: where all came to rest behind that bit's sample point,
  its SOF began there, elsewhere at the bit's end. An edge in an idle bit is a hard synchronisation: the bit begins with
  it, and an SOF begins where a bit of its sender's does, so now always at that bit's end.
- A level forced between the last sample of an intermission and its end made a suspended node forget that it was, if the
  bus had gone bit by bit: its suspended bits began anew with each request.

Since then the random schedules know glitches, too: levels forced for parts of bits, dominant and recessive, often
several in one bit (`--glitches`).
"""


def shown() -> dict[str, str]:
    """Which test shows which purpose: file::name by number."""
    found: dict[str, str] = {}
    for path in sorted(TESTS.glob("test_*.py")):
        for name, number in _decorated(ast.parse(path.read_text(encoding="utf-8"))):
            if number in found:
                sys.exit(f"{number} is shown twice: {found[number]}, {path.name}::{name}")
            found[number] = f"{path.name}::{name}"
    return found


def _decorated(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef):
            continue
        for call in node.decorator_list:
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "shows":
                (argument,) = call.args
                assert isinstance(argument, ast.Constant)
                yield node.name, str(argument.value)


def verdict(number: str, kind: str, tests: dict[str, str]) -> str:
    """What is said of a controller."""
    reason = why_not(number, kind)
    if reason:
        return f"n/a: {reason}"
    if (number, kind) in OPEN:
        return f"**open**: {OPEN[number, kind]}"
    return "passes" if number in tests else "**open**: no test yet"


def page() -> str:
    """The whole page."""
    tests = shown()
    lines = [
        HEAD.format(
            standard=len(PURPOSES) - len(VARIANTS),
            total=len(PURPOSES),
            variants=len(VARIANTS),
            names=", ".join(VARIANTS),
            heads=" | ".join(KINDS.values()),
            rules="|".join("---" for _ in KINDS),
            summary="\n".join(_summary(tests)),
        )
    ]
    chapter = ""
    for purpose in PURPOSES:
        if purpose.number[:3] != chapter:
            chapter = purpose.number[:3]
            lines.append(f"\n## {chapter} {CHAPTERS[chapter]}\n")
            lines.append(f"| Number | Purpose | {' | '.join(KINDS.values())} | Test |")
            lines.append(f"|---|---|{'---|' * len(KINDS)}---|")
        cells = [verdict(purpose.number, kind, tests) for kind in KINDS]
        test = f"`{tests[purpose.number]}`" if purpose.number in tests else ""
        lines.append(f"| {purpose.number} | {purpose.purpose} | {' | '.join(cells)} | {test} |")
    return "\n".join(lines) + "\n"


def _summary(tests: dict[str, str]) -> Iterator[str]:
    for name, begin in (("pass", "passes"), ("do not apply", "n/a"), ("open", "**open**")):
        counts = [
            sum(verdict(purpose.number, kind, tests).startswith(begin) for purpose in PURPOSES)
            for kind in KINDS
        ]
        yield f"| {name} | {' | '.join(str(count) for count in counts)} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
