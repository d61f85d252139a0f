"""`canwire serve --socketcand`: both in one command, both gone at its end."""

from __future__ import annotations

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from tests import warm
from tests.hubs import LONG_S

pytest.importorskip("numpy")


@pytest.mark.conforms("N-33")
def test_both_in_one_command(tmp_path: Path) -> None:
    words = ["serve", "--socket", str(tmp_path / "hub.sock"), "--socketcand", "127.0.0.1:0"]
    with warm.Popen(
        [sys.executable, "-m", "canwire", *words], stdout=subprocess.PIPE, text=True, cwd=tmp_path
    ) as hub:
        assert hub.stdout is not None
        try:
            assert "canwire hub on" in hub.stdout.readline()
            said = hub.stdout.readline()
            assert said.startswith("socketcand on 127.0.0.1:"), said
            with socket.create_connection(
                ("127.0.0.1", int(said.rpartition(":")[2])), timeout=LONG_S
            ) as client:
                client.sendall(b"< open can0 >")
                heard = b""
                while not heard.endswith(b"< ok >"):
                    heard += client.recv(100)
                assert heard == b"< hi >< ok >"
                hub.terminate()
                assert hub.wait(LONG_S) == 0
                while client.recv(100):
                    pass
        finally:
            hub.kill()
