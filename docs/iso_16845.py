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
picosecond by picosecond. Every level that the controller drives is compared with the level that it must drive, and so
are its counters and what it reports to its host (`tests/iso16845/tester.py`). `tests/iso16845/rows` has setup,
disturbance and
expected response of each row.

Numbers follow ISO 16845-1. {standard} of the {total} rows are purposes of the standard that are known in
public; the other {variants} ({names}) are variants that a public list added:
the same errors with a passive controller, or one in restricted operation. The standard also has other chapters,
and a part 2.

An FD controller runs each purpose twice: with classic frames and with FD frames.

| | {heads} |
|---|{rules}|
{summary}

## Where the standard can be read in two ways

**How long an FD acknowledge is.** In canwire the ACK slot of an FD frame is one bit, and a second dominant bit is
tolerated,
as in Bosch's CAN FD 1.0 and the tools of Linux. If the slot always had two bits, all later bits would come one bit
later. Rows count from their field, so they are valid for both readings, with one exception:

**Where the flag of a CRC error begins in an FD frame** (7.2.5, 7.6.10). In ISO 11898-1:2015 it begins in the bit after
the ACK delimiter. With an ACK slot of one bit this is the third bit after the CRC delimiter; with one of two bits it is
the fourth, as public test descriptions say. In canwire it is the bit after the ACK delimiter: the third, or the
fourth if the acknowledge took two bits. An acknowledgement error comes in the third bit in both readings, because a
sender waits for a late acknowledge.

## The long run

In addition to the standard's purposes, a slow reference that was written from the rules alone
(`tests/bus/can/reference`) checks the bus. Random schedules of frames, starts, stops and faults are played on both; the
bus plays them bit by bit, in whole frames, and changing between the two.
`python -m tests.bus.can.reference.long_run` plays any number of schedules. Results of November 2026:

| seeds | frames | faults | errors reported | state changes | arbitrations lost | schedules that differ |
|---|---|---|---|---|---|---|
| 0 to 27,039 | 1,000,676 | 102,575 | 326,429 | 44,360 | 945,627 | 6 |
| 27,040 to 44,299, after the repairs | 638,524 | 65,053 | 210,262 | 28,684 | 602,874 | 4 |
| 44,300 to 71,419, after the last of them | 1,002,228 | 103,141 | 330,921 | 43,814 | 949,009 | 0 |

The ten differences had four causes. All are fixed, and their schedules are part of the short run in CI:

- A passive sender whose missing acknowledge was spared (rule 3, exception A) still counted 8 for a dominant bit in a
  later flag.
- A suspended node began a quarter of a bit early if all others became idle at the sample point of its last suspended
  bit.
- A frame was sent in an idle bit that had begun with a glitch. If all nodes became idle after that bit's sample point,
  the SOF began immediately, otherwise at the bit's end. An edge in an idle bit is a hard synchronisation: the bit
  begins
  with the edge, and an SOF begins with a bit of its sender. So it now always begins at that bit's end.
- A level forced between the last sample of an intermission and its end made a suspended node forget its suspension if
  the
  bus ran bit by bit: its suspended bits started again with each request.

Since then the random schedules also have glitches: levels forced for parts of bits, dominant and recessive, often
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
