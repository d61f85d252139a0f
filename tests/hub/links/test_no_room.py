"""A runtime directory without room for one more file: the error names the socket, and nobody blames the output."""

from __future__ import annotations

import errno
import os
import socket
from pathlib import Path

import pytest

from canwire.commands import main
from canwire.hub.links.unix_socket import sockets
from tests.hub.links.ways import unix_only


class _Full(socket.socket):
    def bind(self, address: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@unix_only
def test_a_full_runtime_directory_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sockets.socket, "socket", _Full)
    path = str(tmp_path / "hub")
    with pytest.raises(OSError, match="No space left on device") as raised:
        sockets.listen_at(path)
    assert raised.value.filename == path
    assert main(["serve", "--socket", path]) == 2
    assert capsys.readouterr().err == f"canwire: [Errno 28] No space left on device: '{path}'\n"
