"""Mutants are drawn by a seed, change what can be changed, and are judged by the tests of their folder."""

from __future__ import annotations

import ast
import subprocess
from pathlib import Path

import pytest

from tests.cases import each
from tests.mutants.__main__ import table
from tests.mutants.drawing import PACKAGE, Mutant, draw, found_again, shares, sites_of
from tests.mutants.judging import Judge
from tests.mutants.selection import stages

ROOT = Path(__file__).resolve().parent.parent
FILE = "src/canwire/room/shop.py"
SHOP = '''"""A shop that sells below 10 pieces at once."""
import sys

__all__ = ["price" + "s"]


def price(pieces: int, cheap: bool = False) -> int:
    """Never less than 1."""
    if pieces < 10 and not cheap:
        return pieces * 3
    if sys.platform == "win32":
        return 7 + 8
    raise ValueError(f"{pieces + 1} pieces are too many" + str(10 - 1))
'''
TESTS = "from canwire.room.shop import price\n\n\ndef test_price():\n    assert price(2) == 6\n"
TREE = {
    FILE: SHOP,
    "src/canwire/__init__.py": "",
    "src/canwire/room/__init__.py": "",
    "tests/room/test_shop.py": TESTS,
    "setup.py": "",
    "pyproject.toml": '[tool.pytest.ini_options]\naddopts = "--import-mode=importlib -p no:canwire"\n',
}


def ways(source: str) -> set[tuple[str, str]]:
    return {(one.before, one.after) for site in sites_of(source, FILE) for one in site}


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """A clone with one file of source and one test for it."""
    root = tmp_path / "small"
    for name, text in TREE.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    subprocess.run(["git", "init", "-q", root], check=True)
    return root


def test_what_is_changed() -> None:
    assert ways(SHOP) == {
        ("pieces < 10 and not cheap", "(pieces < 10 or not cheap)"),
        ("pieces < 10", "(pieces <= 10)"),
        ("10", "11"),
        ("10", "(9)"),
        ("not cheap", "(cheap)"),
        ("False", "True"),
        ("return pieces * 3", "return None"),
        ("pieces * 3", "(pieces // 3)"),
        ("3", "4"),
        ("3", "(2)"),
        ('raise ValueError(f"{pieces + 1} pieces are too many" + str(10 - 1))', "pass"),
    }


@each(
    ("source", "way"),
    [
        ("bell.ring(1)", ("bell.ring(1)", "pass")),
        ("total += 1", ("total += 1", "pass")),
        ("bell.rung = ear", ("bell.rung = ear", "pass")),
        ("while ready(): pass", ("ready()", "(not ready())")),
        ("x = 'ä' if a is b else c", ("a is b", "(a is not b)")),
        ("x = a >> 2 & b", ("a >> 2", "(a << 2)")),
    ],
)
def test_one_way(source: str, way: tuple[str, str]) -> None:
    assert way in ways(source)


def test_each_mutant_stands_where_it_says_and_is_python() -> None:
    for site in sites_of(SHOP, FILE):
        for mutant in site:
            changed = mutant.applied(SHOP)
            assert changed != SHOP
            ast.parse(changed)


def test_the_same_seed_draws_the_same_mutants(small: Path) -> None:
    drawn = [draw(small, 5, seed) for seed in (26, 26, 27)]
    assert drawn[0] == drawn[1] != drawn[2]
    assert len(set(drawn[0])) == 5


def test_every_folder_has_its_share(small: Path) -> None:
    """Also one of a single line, beside one that is forty times as long."""
    for room, source in {"hall": SHOP * 40, "attic": "HEIGHT_M = 2\n"}.items():
        (small / PACKAGE / room).mkdir()
        (small / PACKAGE / room / "file.py").write_text(source)
    drawn = draw(small, 20, 26)
    assert {Path(mutant.file).relative_to(PACKAGE).parts[0] for mutant in drawn} == {"room", "hall", "attic"}


def test_mutants_are_drawn_from_the_source_of_canwire() -> None:
    drawn = draw(ROOT, 3, 26, ["ring.py", "values", "lab"])
    assert {Path(mutant.file).relative_to(PACKAGE).parts[0] for mutant in drawn} == {
        "ring.py",
        "values",
        "lab",
    }


def test_some_folders_alone(small: Path) -> None:
    assert draw(small, 5, 26, ["room"]) == draw(small, 5, 26)
    assert draw(small, 5, 26, ["ring.py"]) == []


def test_shares_follow_the_lines() -> None:
    assert shares({"a": 900, "b": 99, "c": 1}, 10) == {"a": 9, "b": 1, "c": 1}
    assert sum(shares({"a": 50, "b": 35, "c": 15}, 7).values()) == 7


def test_a_mutant_is_found_again_where_its_line_has_moved(small: Path) -> None:
    mutant = Mutant(FILE, 9, 7, "pieces < 10", "(pieces <= 10)", "price")
    assert found_again(small, mutant) == mutant
    (small / FILE).write_text("# one more line\n" + SHOP)
    assert found_again(small, mutant) == mutant._replace(line=10)
    (small / FILE).write_text(SHOP.replace("pieces < 10", "pieces < 11"))
    assert found_again(small, mutant) is None


def test_the_nearest_tests_that_mention_it_come_first() -> None:
    first, rest = stages(ROOT, Mutant("src/canwire/bus/can/bus.py", 1, 0, "1", "2", "CanBus"))
    assert all(file.startswith("tests/bus/") for file in first + rest)
    alone = stages(ROOT, Mutant("src/canwire/ring.py", 1, 0, "1", "2", "Ring"))
    assert alone == [["tests/test_ring.py"]]


def test_verdicts(small: Path, tmp_path: Path) -> None:
    judge = Judge(small, tmp_path / "scratch")
    noticed = Mutant(FILE, 10, 15, "pieces * 3", "(pieces // 3)", "price")
    unnoticed = Mutant(FILE, 9, 7, "pieces < 10", "(pieces <= 10)", "price")
    assert judge.verdict(noticed)[:2] == ("killed", "tests/room/test_shop.py::test_price")
    assert judge.verdict(unnoticed).status == "survived"
    assert (small / FILE).read_text() == SHOP


def test_a_test_that_fails_on_the_unchanged_source_kills_nothing(small: Path, tmp_path: Path) -> None:
    failing = "tests/room/test_always.py::test_price_of_the_shop"
    (small / failing.partition("::")[0]).write_text("def test_price_of_the_shop():\n    assert False\n")
    unnoticed = Mutant(FILE, 9, 7, "pieces < 10", "(pieces <= 10)", "price")
    judge = Judge(small, tmp_path / "scratch")
    assert judge.verdict(unnoticed)[:2] == ("killed", failing)
    assert judge.failing_anyway([(unnoticed, failing)]) == [unnoticed]
    assert judge.verdict(unnoticed).status == "survived"


def test_a_test_that_fails_by_chance_kills_nothing(small: Path, tmp_path: Path) -> None:
    """On a busy machine one does now and then; it has to fail a second time."""
    once = (
        "from pathlib import Path\n\n\ndef test_price_of_the_shop():\n"
        f"    seen = Path({str(tmp_path / 'seen')!r})\n    before = seen.exists()\n"
        "    seen.touch()\n    assert before\n"
    )
    (small / "tests/room/test_by_chance.py").write_text(once)
    unnoticed = Mutant(FILE, 9, 7, "pieces < 10", "(pieces <= 10)", "price")
    assert Judge(small, tmp_path / "scratch").verdict(unnoticed).status == "survived"
    assert (tmp_path / "seen").exists()


def test_the_table() -> None:
    rows = [
        {"file": "src/canwire/bus/a.py", "status": "killed", "seconds": 60},
        {"file": "src/canwire/bus/a.py", "status": "survived", "seconds": 30},
        {"file": "src/canwire/ring.py", "status": "killed", "seconds": 30},
    ]
    lines = table(rows).splitlines()
    assert lines[2:] == [
        "| bus | 2 | 1 | 50% |",
        "| ring.py | 1 | 1 | 100% |",
        "| all | 3 | 2 | 67% |",
        "",
        "2 minutes",
    ]
