"""The how-to pages do what they say: their Python prints what stands below it, their commands succeed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.docs.blocks import ROOT, blocks, run_console, run_python, run_tests

PAGES = sorted((ROOT / "docs" / "how-to").glob("*.md"))
needs = {
    "canopen": "canopen",
    "ci": "can",
    "databases": "cantools",
    "isotp": "isotp",
    "j1939": "j1939",
    "lin": "ldfparser",
    "uds": "udsoncan",
    "virtual-time": "can",
}


def has(page: Path, language: str) -> bool:
    return any(block.language == language for block in blocks(page))


@pytest.mark.parametrize("page", [page for page in PAGES if has(page, "python")], ids=lambda page: page.stem)
def test_python(page: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Programs that name no hub find none of the user's, so they have one in this process."""
    if page.stem in needs:
        pytest.importorskip(needs[page.stem])
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(ROOT)
    whole_files = [block for block in blocks(page) if block.mark.startswith("file: ")]
    assert run_python(page) + len(whole_files) >= 1


@pytest.mark.parametrize("page", [page for page in PAGES if has(page, "console")], ids=lambda page: page.stem)
def test_commands(page: Path, tmp_path: Path) -> None:
    assert run_console(page, tmp_path)


def test_the_tests_of_the_ci_page(tmp_path: Path) -> None:
    pytest.importorskip("can")
    page = ROOT / "docs" / "how-to" / "ci.md"
    for block in blocks(page):
        if block.mark.startswith("file: "):
            (tmp_path / block.mark.removeprefix("file: ")).write_text(block.text)
    assert "2 passed" in run_tests(tmp_path)
