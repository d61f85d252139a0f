"""Where sockets live: nobody else's directory, and none where others could put a socket in the place of ours."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import pytest

from canwire.places import runtime_directory

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners and rights as Unix has them")


def test_a_directory_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tmp_path.chmod(0o755)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert runtime_directory() == str(tmp_path)


def test_one_where_others_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    for mode in (0o777, 0o720, 0o702):
        tmp_path.chmod(mode)
        with pytest.raises(PermissionError, match="others may write there; chmod go-w"):
            runtime_directory()
    tmp_path.chmod(0o1777)  # sticky: nobody can move or replace what is ours
    assert runtime_directory() == str(tmp_path)


def test_somebody_elses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    own = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    with pytest.raises(PermissionError, match=f"it belongs to user {own}"):
        runtime_directory()


@pytest.mark.parametrize("what", ["link", "file", "open", "foreign"])
def test_ours_in_the_temporary_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str) -> None:
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(tmp_path))
    own = tmp_path / f"canwire-{os.getuid()}"
    assert runtime_directory() == str(own)
    assert own.stat().st_mode & 0o777 == 0o700
    if what == "link":
        own.rename(tmp_path / "elsewhere")
        own.symlink_to(tmp_path / "elsewhere")
    elif what == "file":
        own.rmdir()
        own.touch(0o600)
    elif what == "open":
        own.chmod(0o701)
    else:
        somebody = os.getuid() + 1
        monkeypatch.setattr(os, "getuid", lambda: somebody)
        (tmp_path / f"canwire-{somebody}").mkdir(0o700)
    with pytest.raises((PermissionError, FileExistsError)):
        runtime_directory()
