"""Shared memory as files: for its user alone, gone as soon as it can be, and never somebody else's."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from canwire.platform.portable import memory
from canwire.platform.portable.memory import (
    Memory,
    close_descriptors,
    create_memory,
    duplicate,
    map_memory,
    remove_stale,
)
from tests.descriptors import open_descriptors
from tests.missing import not_on_windows

NAME = f"canwire-{os.getpid()}-{'a' * 32}.ring"


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where memory lies."""
    tmp_path.chmod(0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return tmp_path


@not_on_windows("has the rights of folders instead")
def test_both_ends_see_the_same_and_then_the_name_is_gone(place: Path) -> None:
    made = create_memory(4096)
    [name] = place.iterdir()
    assert stat.S_IMODE(name.stat().st_mode) == 0o600
    here, opened = map_memory(made), Memory.open(made.path)
    there = map_memory(opened)
    opened.close()
    assert list(place.iterdir()) == [name]
    made.close()
    made.close()
    assert list(place.iterdir()) == []
    here[5] = 17
    assert (there[5], len(there), bytes(there[6:])) == (17, 4096, bytes(4090))


def test_names_are_never_the_same(place: Path) -> None:
    made = [create_memory(8) for _ in range(50)]
    assert len({memory.path for memory in made}) == 50
    close_descriptors(*made)


def test_the_name_stays_for_as_long_as_somebody_may_pass_it_on(place: Path) -> None:
    made = create_memory(8)
    (copy,) = duplicate((made,))
    made.close()
    assert copy.path == str(*place.iterdir())
    copy.close()
    assert list(place.iterdir()) == []


@not_on_windows("has no list of what is open")
def test_no_room_is_an_error_that_leaves_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int, size: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(memory.os, "ftruncate", full)
    before = open_descriptors()
    with pytest.raises(OSError, match="No space"):
        create_memory(8)
    assert list(place.iterdir()) == []
    assert open_descriptors() == before


@not_on_windows("has the rights of folders instead")
@pytest.mark.parametrize("mode", [0o660, 0o604, 0o777])
def test_a_file_that_others_may_open_is_refused(place: Path, mode: int) -> None:
    (place / NAME).write_bytes(bytes(8))
    (place / NAME).chmod(mode)
    with pytest.raises(PermissionError, match="others may open it"):
        Memory.open(str(place / NAME))


@not_on_windows("has the rights of folders instead")
def test_another_users_file_is_refused(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (place / NAME).touch(0o600)
    stranger = (place / NAME).stat().st_uid + 1
    if os.geteuid() == 0:
        os.chown(place / NAME, stranger, -1)
    else:
        monkeypatch.setattr(os, "geteuid", lambda: stranger)
    with pytest.raises(PermissionError, match="belongs to user"):
        Memory.open(str(place / NAME))


@pytest.mark.parametrize(
    "name",
    ["precious", pytest.param("../" + NAME + "x", id="above"), f"canwire-1-{'g' * 32}.ring", "canwire.sock"],
)
def test_other_names_are_not_even_looked_at(place: Path, name: str) -> None:
    with pytest.raises(PermissionError, match="not a name of shared memory"):
        Memory.open(str(place / name))


@not_on_windows("has the rights of folders instead")
def test_links_and_directories_are_refused(place: Path) -> None:
    (place / "precious").write_bytes(bytes(8))
    (place / NAME).symlink_to(place / "precious")
    with pytest.raises(OSError, match="symbolic"):
        Memory.open(str(place / NAME))
    (place / NAME).unlink()
    (place / NAME).mkdir()
    with pytest.raises(OSError, match="directory"):
        Memory.open(str(place / NAME))


@not_on_windows("refuses to remove what lives: trying tells")
def test_what_a_killed_process_left_is_removed_by_the_next_that_makes_some(place: Path) -> None:
    code = "import os; from canwire.platform.portable.memory import create_memory; m = create_memory(8); os._exit(9)"
    source = str(Path(memory.__file__).parent.parent.parent.parent)
    subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": source}, check=False, timeout=30
    )
    [left] = place.iterdir()
    (place / "precious.ring").touch()
    (place / NAME).touch()  # of a process that lives
    made = create_memory(8)
    made.close()
    assert sorted(path.name for path in place.iterdir()) == sorted([NAME, "precious.ring"])
    assert not left.exists()


@not_on_windows("refuses to remove what lives: trying tells")
def test_numbers_that_are_no_process_are_left_alone(place: Path) -> None:
    name = f"canwire-{2**80}-{'0' * 32}.ring"
    (place / name).touch()
    assert remove_stale(str(place)) == []
    assert (place / name).exists()
