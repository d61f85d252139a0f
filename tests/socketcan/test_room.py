"""Places that are full: another one is taken, or it is said; nothing is mapped that there is no memory for."""

from __future__ import annotations

import errno
import os
import socket
import tempfile
from pathlib import Path

import pytest

from canwire import CanwireError
from canwire.socketcan import launch, rings
from canwire.socketcan.rings import Rings


@pytest.mark.finding("socketcan 16")
def test_a_full_runtime_directory_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.setattr(launch, "_LONGEST_PATH", 1000)
    monkeypatch.setattr(tempfile, "tempdir", "/usual")
    monkeypatch.setattr(launch, "has_room", lambda place, size: True)
    assert launch._place() == str(tmp_path)
    monkeypatch.setattr(launch, "has_room", lambda place, size: place == "/usual")
    assert launch._place() == "/usual"
    monkeypatch.setattr(launch, "has_room", lambda place, size: False)
    with pytest.raises(CanwireError, match=f"{tmp_path} and /usual: less than 8 MB are free there"):
        launch._place()


@pytest.mark.finding("socketcan 16")
def test_no_socket_without_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = Rings(str(tmp_path / "rings"), launch.shim())
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with ours, theirs:
        made.pair(0, ours.fileno())
        monkeypatch.setattr(rings, "has_room", lambda directory, size: False)
        with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)) as failed:
            made.pair(1, ours.fileno())
    assert (failed.value.errno, failed.value.filename) == (errno.ENOSPC, str(tmp_path))
