"""`canwire web` as a process: one line, a clean end, and clear words for what cannot be."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from canwire.commands import main
from tests import warm

httpx = pytest.importorskip("httpx2")
pytest.importorskip("uvicorn")
LONG_S = 30


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.conforms("PG-01")
def test_it_prints_one_address_and_ends_cleanly(hub_address: str, number: signal.Signals) -> None:
    command = [sys.executable, "-m", "canwire", "web", "--hub", hub_address]
    with warm.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        printed = process.stdout.readline()
        address = re.fullmatch(r"canwire web: (http://127\.0\.0\.1:\d+/\?token=\S+)\n", printed)
        assert address is not None, printed
        assert httpx.get(address[1], follow_redirects=True, timeout=LONG_S).status_code == 200
        process.send_signal(number)
        rest, complaints = process.communicate(timeout=LONG_S)
    assert (process.returncode, rest, complaints) == (0, "", "")


def test_without_a_hub_it_says_how_to_start_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("CANWIRE_HUB", raising=False)
    assert main(["web"]) == 2
    assert "`canwire serve` starts one" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--port", "65536"], "--port 65536"),
        (["--port", "-1"], "--port -1"),
        (["--db", "/nowhere/car.dbc"], "there is no such file"),
    ],
)
def test_what_cannot_be_is_refused(
    hub_address: str, words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["web", "--hub", hub_address, *words]) == 2
    assert complaint in capsys.readouterr().err


def test_a_port_that_is_taken_is_named(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["web", "--hub", hub_address, "--port", str(port)]) == 2
    assert f"--port {port}" in capsys.readouterr().err


def test_a_description_that_means_nothing_is_refused(
    hub_address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("cantools")
    broken = tmp_path / "broken.dbc"
    broken.write_text("BO_ what\n")
    assert main(["web", "--hub", hub_address, "--db", str(broken)]) == 2
    assert f"canwire: {broken}: " in capsys.readouterr().err


@pytest.mark.finding("page 7")
def test_the_token_is_handed_to_a_browser_in_a_file_of_the_users_own() -> None:
    """Everybody can read a program's arguments."""
    from canwire.commands.web.verb import leading_to

    with leading_to("http://127.0.0.1:1/?token=secret") as url:
        assert "secret" not in url
        path = Path(url.removeprefix("file://"))
        assert path.stat().st_mode & 0o777 == 0o600
        assert 'url=http://127.0.0.1:1/?token=secret"' in path.read_text()
    assert not path.exists()


@pytest.mark.finding("page 13")
def test_the_usual_port_is_taken_where_it_is_free(hub_address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    import canwire
    from canwire.web import server

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        monkeypatch.setattr(server, "USUAL_PORT", port)
        with canwire.connect(hub_address, name="web") as hub:
            site = server.Site(hub, canwire.epoch_ns, port=None)
            assert site.port != port
            site.close()
    with canwire.connect(hub_address, name="web") as hub:
        site = server.Site(hub, canwire.epoch_ns, port=None)
        assert site.port == port
        site.close()
