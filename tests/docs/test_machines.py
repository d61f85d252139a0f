"""docs/machines.md: what it shows on one machine runs, and its files are what canwire reads."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire.hub.links.network.access import Access, Login, Router, load
from canwire.hub.protocol.messages import VERSION
from tests.docs.blocks import ROOT, blocks, run_console
from tests.hubs import shared_file

PAGE = ROOT / "docs" / "machines.md"


@pytest.fixture
def default_port() -> Iterator[None]:
    """The port of an offer that asks for no other: a machine has one, whoever tests this clone or another one."""
    import fcntl

    with shared_file("default-port").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.mark.realtime
@pytest.mark.conforms("PL-11", "PL-25")
@pytest.mark.usefixtures("default_port")
def test_the_commands_of_the_page(tmp_path: Path) -> None:
    said = run_console(PAGE, tmp_path)
    assert "offered as zenoh://lab/127.0.0.1" in said
    shown = f"fast time, version {VERSION}"
    assert shown in said
    assert shown in PAGE.read_text(encoding="utf-8")
    assert "HW000001  usb-to-can-fd  USB-to-CAN FD (simulated)" in said


def test_the_files_of_the_page(tmp_path: Path) -> None:
    hub, program, router = [block.text for block in blocks(PAGE) if block.language == "toml"]
    for name, text in (("lab.toml", hub), ("me.toml", program), ("behind.toml", hub + router)):
        (tmp_path / name).write_text(text)
    users = load(Access, str(tmp_path / "lab.toml")).users
    login = load(Login, str(tmp_path / "me.toml"))
    assert users[login.user].password == login.password
    behind = load(Access, str(tmp_path / "behind.toml"))
    assert (behind.users, behind.router) == (users, Router(user="bench", password="the hub's own"))
    assert {name: user.may for name, user in users.items()} == {"runner": "configure", "visitor": "listen"}
