"""The results of a campaign as JUnit XML, which build servers show: one test case per run."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

from canwire.campaigns.playing import CampaignRun
from canwire.campaigns.whole import whole
from canwire.errors import BadValue

_ENDINGS = (".xml", ".html")
_OUTSIDE_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # XML 1.0, 2.2


class Played(NamedTuple):
    """A campaign that was played: its file as given on the command line, its name, and its seed."""

    path: str
    name: str
    seed: int

    def repetition(self, number: int) -> str:
        """The command that repeats run `number`."""
        return f"canwire campaign {self.path} --seed {self.seed} --repeat {number}"


def check_report(path: str | Path) -> Path:
    """`path`, if a report can be written there. Raises BadValue for an unknown file extension, OSError."""
    path = Path(path)
    if path.suffix not in _ENDINGS:
        raise BadValue(
            f"{path}: a report is JUnit XML in a file whose name ends in .xml, or a page in one that ends in .html"
        )
    if not path.parent.is_dir():
        raise FileNotFoundError(2, "there is no such folder", str(path.parent))
    return path


def write_junit(path: str | Path, played: Played, runs: Iterable[CampaignRun]) -> None:
    """Write the report, whole or not at all: "failed" is a failure, every other verdict but "passed" an error."""
    path = check_report(path)
    ordered = sorted(runs, key=lambda run: run.number)
    kinds = Counter(_kind(run) for run in ordered)
    totals = {
        "tests": str(len(ordered)),
        "failures": str(kinds["failure"]),
        "errors": str(kinds["error"]),
        "time": f"{sum(run.wall_s for run in ordered):.6f}",
    }
    root = Element("testsuites", totals)
    suite = SubElement(root, "testsuite", {"name": played.name, "skipped": "0", **totals})
    SubElement(SubElement(suite, "properties"), "property", {"name": "seed", "value": str(played.seed)})
    for run in ordered:
        _add(suite, played, run)
    indent(root)
    with whole(path) as part:
        ElementTree(root).write(part, encoding="utf-8", xml_declaration=True)


def _kind(run: CampaignRun) -> str:
    return {"passed": "", "failed": "failure"}.get(run.verdict, "error")


def _add(suite: Element, played: Played, run: CampaignRun) -> None:
    parameters = " ".join(f"{name}={value}" for name, value in run.parameters.items())
    case = SubElement(
        suite,
        "testcase",
        {
            "classname": f"{Path(played.path).stem}.{played.name}",
            "name": _legal(f"run {run.number} {parameters}".strip()),
            "time": f"{run.wall_s:.6f}",
        },
    )
    if kind := _kind(run):
        told = {"message": _legal(run.reason), "type": run.verdict}
        again = f"repeat it: {played.repetition(run.number)}"
        parts = [run.trace.rstrip(), again, run.smallest]
        SubElement(case, kind, told).text = _legal("\n".join(filter(None, parts)))
    if run.output:
        SubElement(case, "system-out").text = _legal(run.output)


def _legal(text: str) -> str:
    """Replace characters that are not allowed in XML, even escaped, by Python escape sequences."""
    return _OUTSIDE_XML.sub(lambda found: found.group().encode("unicode_escape").decode(), text)
