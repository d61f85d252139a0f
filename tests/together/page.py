"""The tables of docs/sharing.md, made of table.py: `python -m tests.together.page` writes them anew."""

from __future__ import annotations

from pathlib import Path

from tests.together.adapter_table import (
    ADAPTER_REFUSES,
    ADAPTERS,
    HOST_STAYS_AWAY,
    NOT_APPLICABLE,
    programs,
)
from tests.together.hearing import HEARS, Hears
from tests.together.table import DONGLE, EVENTS, KINDS, REFUSES, SEES, Line

PAGE = Path(__file__).parent.parent.parent / "docs" / "sharing.md"
_MARK = "<!-- {} -->"


def tables() -> dict[str, str]:
    """Their text by the name in the page's marks."""
    return {
        "answers": _answers(),
        "sees": _sees(),
        "hears": _hears(),
        "refuses": _refuses(),
        "adapters": _adapters(),
    }


def written(text: str) -> str:
    """The page with its tables as they should be."""
    for name, table in tables().items():
        begin, end = _MARK.format(name), _MARK.format(f"end of {name}")
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n{table}{end}{rest.partition(end)[2]}"
    return text


def _answers() -> str:
    rows = [
        "| what happens | program | control is free | somebody holds it | set up by its own kind |",
        "|---" * 5 + "|",
    ]
    for event, told in EVENTS.items():
        same: dict[tuple[str, ...], list[str]] = {}
        for kind in KINDS:
            if kind in told:
                answers = told[kind]
                same.setdefault((answers.free, answers.held, answers.kin), []).append(kind)
        rows += [f"| {event} | {', '.join(kinds)} | {' | '.join(words)} |" for words, kinds in same.items()]
    return "\n".join(rows) + "\n"


def _sees() -> str:
    rows = ["| program | " + " | ".join(line.value for line in Line) + " |", "|---" * (len(Line) + 1) + "|"]
    rows += [f"| {kind} | " + " | ".join(SEES[kind][line] for line in Line) + " |" for kind in KINDS]
    return "\n".join(rows) + "\n"


def _hears() -> str:
    heads = (
        "receives errors",
        "receives states",
        "receives arbitration losses",
        "filter as set",
        "notified when another program stops the line",
    )
    assert len(heads) == len(Hears._fields)
    rows = ["| program | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
    same: dict[Hears, list[str]] = {}
    for kind in KINDS:
        same.setdefault(HEARS[kind], []).append(kind)
    rows += [f"| {', '.join(kinds)} | {' | '.join(words)} |" for words, kinds in same.items()]
    return "\n".join(rows) + "\n"


def _refuses() -> str:
    rows = ["| program | board | result |", "|---|---|---|"]
    same: dict[tuple[str, str], list[str]] = {}
    for (kind, board), told in REFUSES.items():
        same.setdefault((kind, told), []).append(board)
    rows += [f"| {kind} | {', '.join(boards)} | {told} |" for (kind, told), boards in same.items()]
    return "\n".join(rows) + "\n"


def _adapters() -> str:
    rows = ["| adapter | what happens | program | result |", "|---" * 4 + "|"]
    for adapter in ADAPTERS:
        never = {event: why for (on, event), why in NOT_APPLICABLE.items() if on == adapter}
        there = ", ".join(programs(adapter))
        rows.append(
            f"| {adapter} | {', '.join(event for event in EVENTS if event not in never)} | {there} | as above |"
        )
        rows += [f"| {adapter} | {event} | {there} | not applicable: {why} |" for event, why in never.items()]
        refused = {kind: told for (kind, on), told in ADAPTER_REFUSES.items() if on == adapter}
        rows += [f"| {adapter} | anything | {kind} | {told} |" for kind, told in refused.items()]
    rows.append(f"| {', '.join(ADAPTERS)} | anything | {DONGLE} | {HOST_STAYS_AWAY} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
