"""A release takes the fragments of changes/ into the changelog, with its date, and sets the version."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

from canwire import __version__

ROOT = Path(__file__).parent.parent
_SPEC = importlib.util.spec_from_file_location("release", ROOT / ".ci" / "release.py")
assert _SPEC is not None
assert _SPEC.loader is not None
release = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(release)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "changes").mkdir()
    (tmp_path / "src" / "canwire").mkdir(parents=True)
    (tmp_path / "src" / "canwire" / "version.py").write_text('__version__ = "0.2.0"\n')
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## 0.2.0 - 2026-11-23\n\n- Old.\n")
    (tmp_path / "changes" / "README.md").write_text("How.\n")
    return tmp_path


def test_changes_get_their_heading(project: Path) -> None:
    (project / "changes" / "b.md").write_text("- Second.\n")
    (project / "changes" / "a.md").write_text("- First,\n  in two lines.\n")
    release.release(project, "0.3.0", "2026-12-01")
    assert (project / "CHANGELOG.md").read_text() == (
        "# Changelog\n\n## 0.3.0 - 2026-12-01\n\n- First,\n  in two lines.\n- Second.\n\n"
        "## 0.2.0 - 2026-11-23\n\n- Old.\n"
    )
    assert (project / "src" / "canwire" / "version.py").read_text() == '__version__ = "0.3.0"\n'
    assert [path.name for path in (project / "changes").iterdir()] == ["README.md"]


@pytest.mark.parametrize(("version", "text", "why"), [
    ("0.3", "- A change.\n", "three numbers"),
    ("0.3.0", "", "begins with"),
    ("0.2.0", "- A change.\n", "there already"),
])  # fmt: skip
def test_what_is_no_release_changes_nothing(project: Path, version: str, text: str, why: str) -> None:
    (project / "changes" / "a.md").write_text(text)
    before = (project / "CHANGELOG.md").read_text()
    with pytest.raises(SystemExit, match=why):
        release.release(project, version, "2026-12-01")
    assert (project / "CHANGELOG.md").read_text() == before
    assert (project / "changes" / "a.md").exists()


def test_the_changelog_has_this_version_and_a_date_for_each() -> None:
    headings = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ - \d{4}-\d\d-\d\d", heading) for heading in headings)
    assert headings[0].startswith(f"{__version__} ")


def test_every_fragment_is_one_that_a_release_takes() -> None:
    assert all(part.read_text(encoding="utf-8").startswith("- ") for part in release.fragments(ROOT))
