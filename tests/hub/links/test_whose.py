"""A program looks whose hub it is that answers, before it maps that hub's memory."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import pytest

from canwire import HubError
from canwire.platform import PORTABLE

sockets = pytest.importorskip("canwire.hub.links.unix_socket.sockets") if not PORTABLE else None
pytestmark = [
    pytest.mark.skipif(PORTABLE, reason="other users are kept out by a token there"),
    pytest.mark.finding("faults-2 10"),
]


@pytest.mark.parametrize(
    ("me", "hubs", "lets"), [(1000, 1000, True), (1000, 0, True), (0, 1000, True), (1000, 1001, False)]
)
def test_another_users_hub_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, me: int, hubs: int, lets: bool
) -> None:
    path = str(tmp_path / "hub.sock")
    assert sockets is not None
    with closing(sockets.listen_at(path)):
        monkeypatch.setattr(os, "geteuid", lambda: me)
        monkeypatch.setattr(sockets, "peer_of", lambda _: (1, hubs))
        if lets:
            sockets.dial(path).close()
        else:
            with pytest.raises(HubError, match="user 1001 listens there, not 1000"):
                sockets.dial(path)
