"""No page's block is left out: a page with programs or commands has a test that runs them, and its verbs exist."""

from __future__ import annotations

import argparse
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire.commands import VERBS
from tests.cases import each
from tests.docs.blocks import ROOT, blocks

RUN_BY = {
    "README.md": "test_readme.py",
    "five-programs.md": "test_five_programs.py",
    "faults.md": "test_faults.py",
    "fd-controllers.md": "test_fd_controllers.py",
    "machines.md": "test_machines.py",
    "native.md": "test_native.py",
    "native-dotnet.md": "test_native_dotnet.py",
    "native-drivers.md": "test_native_drivers.py",
    "platforms.md": "test_platforms.py",
    "porting-acan.md": "test_porting_acan.py",
    "porting-candrv.md": "test_porting_candrv.py",
    "porting-vci.md": "test_porting_vci.py",
    "python-can.md": "test_python_can.py",
    "slcan.md": "test_slcan.py",
    "socketcan.md": "test_socketcan.py",
    "time.md": "test_time.py",
    "tools.md": "test_tools.py",
    "web.md": "test_web.py",
    "ecu-tests.md": "test_tutorials.py",
    "lab.md": "test_tutorials.py",
    "shared-boards.md": "test_tutorials.py",
}
FOLDERS = {"how-to": "test_how_to.py"}
NOT_RUN = {  # blocks that nothing here can run, by the words in front of them
    "two machines": "machines.md: another machine takes part",
}
INDENTED = {  # commands that stand in no block
    r"canwire campaign late\.py .* --flip can0:108:41": "what --shrink printed",
    r"pip (un)?install .*|python3 -m venv .*": "installs: CI's own steps do that with a wheel and an sdist",
    r"canwire demo": "tests/commands/test_demo.py",
    r"canwire share /dev/ttyUSB0 .*": "an adapter: tests/drivers/slcan_dongle plays some",
    r"canwire slcan .*": "test_slcan.py has their words parsed, tests/commands/test_slcan.py starts them",
    r"canwire campaign .* --cluster dask:.*": "a cluster: tests/campaigns/test_cluster.py has one",
    r"CANWIRE_PLATFORM=portable python -m pytest .*": "tests/platform/test_portable_suite.py runs a part of it",
}
RAN = ("console", "python", "sh")
HISTORY = {"roadmap.md", "CHANGELOG.md"}
PAGES = [
    ROOT / "README.md",
    *(page for page in sorted((ROOT / "docs").rglob("*.md")) if "reference" not in page.parts),
]
NAMED = re.compile(r"`canwire ([^`]+)`|^(?:\$|   ) canwire (.+)$", re.MULTILINE)


@pytest.mark.conforms("N-15")
def test_every_page_with_blocks_has_a_test() -> None:
    with_blocks = {page for page in PAGES if any(block.language in RAN for block in blocks(page))}
    names = {page.name for page in with_blocks if page.parent.name not in FOLDERS}
    assert names == set(RUN_BY)
    for page in with_blocks:
        test = ROOT / "tests" / "docs" / (FOLDERS.get(page.parent.name) or RUN_BY[page.name])
        text = test.read_text(encoding="utf-8")
        assert page.name in text or page.parent.name in FOLDERS or f'"{page.parent.name}"' in text, test


def test_blocks_for_no_test_say_why() -> None:
    """Commands for a shell are console blocks, which are run; others carry one of the reasons, or have a test."""
    found = [(page.name, block.mark) for page in PAGES for block in blocks(page) if block.language == "sh"]
    assert {mark for _, mark in found if mark} == set(NOT_RUN)
    for name in {name for name, mark in found if not mark}:
        assert 'fenced("sh")' in (ROOT / "tests" / "docs" / RUN_BY[name]).read_text(encoding="utf-8")


def test_indented_commands_say_why() -> None:
    lines = [
        line.strip()
        for page in PAGES
        for line in page.read_text(encoding="utf-8").splitlines()
        if re.match(r"    (?:canwire|pip|python3?|CANWIRE_\w+=\S+) ", line)
    ]
    assert [line for line in lines if not any(re.fullmatch(known, line) for known in INDENTED)] == []
    assert [known for known in INDENTED if not any(re.fullmatch(known, line) for line in lines)] == []


def options_of(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Its own, and those of its sub-verbs."""
    for action in parser._actions:
        yield from action.option_strings
        if isinstance(action, argparse._SubParsersAction):
            for sub in action.choices.values():
                yield from options_of(sub)


@pytest.mark.conforms("N-15")
@each("page", [page for page in PAGES if page.name not in HISTORY], ids=lambda page: page.name)
def test_its_commands_are_ones_there_are(page: Path) -> None:
    """Verb and long options of whatever a page mentions in passing."""
    for inline, line in NAMED.findall(page.read_text(encoding="utf-8")):
        verb, *words = (inline or line).split()
        if verb in ("help", "--version", "VERB"):
            continue
        assert verb in VERBS, f"canwire {verb}"
        parser = argparse.ArgumentParser()
        importlib.import_module(VERBS[verb].module).add_arguments(parser)
        own = words[: words.index("&&")] if "&&" in words else words
        known = {*options_of(parser), "--"}
        if verb == "run":  # what stands behind are a program's own words
            continue
        asked = {word.partition("=")[0] for word in own if word.startswith("--")}
        assert asked <= known, f"canwire {inline or line}"
