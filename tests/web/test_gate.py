"""Strangers are refused before any view is asked."""

from __future__ import annotations

import json
import socket
from contextlib import suppress
from typing import TYPE_CHECKING

import pytest
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.testclient import TestClient
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.exceptions import ConnectionClosed, InvalidMessage
from websockets.sync.client import ClientConnection, connect

from canwire.web import patience
from canwire.web.gate import BODY_BYTES, Gate
from tests.hubs import LONG_S

if TYPE_CHECKING:
    from collections.abc import Iterator

    import httpx2 as httpx

    from canwire.web.server import Site

TOKEN = "right-token"
HOST = "127.0.0.1:8080"
OWN = {"origin": f"http://{HOST}"}

pytestmark = pytest.mark.conforms("PG-01")


async def _look(request: Request) -> PlainTextResponse:
    await request.body()
    return PlainTextResponse(f"writer: {request.scope['writer']}")


async def _talk(socket: WebSocket) -> None:
    await socket.accept()
    await socket.send_text(f"writer: {socket.scope['writer']}")
    await socket.close()


APP = Gate(
    Starlette(routes=[Route("/look", _look, methods=["GET", "POST"]), WebSocketRoute("/talk", _talk)]),
    TOKEN,
    [HOST],
    8080,
    viewers=True,
)
CLOSED = Gate(Starlette(routes=[Route("/look", _look), WebSocketRoute("/talk", _talk)]), TOKEN, [HOST], 8080)


@pytest.fixture
def asking() -> Iterator[TestClient]:
    with TestClient(APP, base_url=f"http://{HOST}", follow_redirects=False) as made:
        yield made


def test_without_a_token_one_may_look(asking: TestClient) -> None:
    assert asking.get("/look").text == "writer: False"


@pytest.mark.finding("page 7", "page B8")
def test_where_viewers_are_not_let_in_nobody_looks_without_the_token() -> None:
    with TestClient(CLOSED, base_url=f"http://{HOST}") as asking:
        assert asking.get("/look").status_code == 403
        with pytest.raises(WebSocketDisconnect), asking.websocket_connect(f"ws://{HOST}/talk"):
            pass
        assert asking.get(f"/look?token={TOKEN}").text == "writer: True"


def test_who_comes_from_elsewhere_is_led_on_by_a_page_of_our_own(asking: TestClient) -> None:
    """A strict cookie is not sent along where a redirection of another site's leads to."""
    answer = asking.get(f"/look?a=%3C&token={TOKEN}", headers={"sec-fetch-site": "cross-site"})
    assert answer.text == '<meta http-equiv="refresh" content="0;url=/look?a=%3C">'
    assert "set-cookie" in answer.headers


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_without_a_token_nothing_can_be_changed(asking: TestClient, method: str) -> None:
    assert asking.request(method, "/look", headers=OWN).status_code == 403


def test_the_token_is_kept_and_leaves_the_address(asking: TestClient) -> None:
    answer = asking.get(f"/look?a=1&token={TOKEN}")
    assert answer.status_code == 303
    assert answer.headers["location"] == "/look?a=1"
    cookie = answer.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=strict" in cookie
    assert asking.get("/look").text == "writer: True"
    assert asking.post("/look", headers=OWN).status_code == 200


def test_a_path_of_two_slashes_leads_nowhere_else(asking: TestClient) -> None:
    answer = asking.get(f"http://{HOST}//other.example/?token={TOKEN}")
    assert answer.headers["location"] == "/other.example/"


@pytest.mark.parametrize("token", ["", "wrong", TOKEN[:-1], TOKEN + "x", "ä"])
def test_a_wrong_token_is_refused(asking: TestClient, token: str) -> None:
    assert asking.get("/look", params={"token": token}).status_code == 403
    assert asking.get("/look").text == "writer: False"


def test_a_wrong_cookie_gives_no_rights(asking: TestClient) -> None:
    asking.cookies.set("canwire-token-8080", "wrong")
    assert asking.get("/look").text == "writer: False"
    assert asking.post("/look", headers=OWN).status_code == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8080", "127.0.0.1:81", "127.0.0.1", ""])
def test_other_names_are_refused(asking: TestClient, host: str) -> None:
    """A foreign name that resolves to the loopback address: DNS rebinding."""
    assert asking.get("/look", headers={"host": host}).status_code == 421


FOREIGN = ["http://evil.example", "null", "https://127.0.0.1:8080", "http://127.0.0.1:9999", ""]


@pytest.mark.parametrize("origin", FOREIGN)
def test_foreign_pages_are_refused_with_or_without_the_token(asking: TestClient, origin: str) -> None:
    asking.get(f"/look?token={TOKEN}")
    assert asking.get("/look", headers={"origin": origin}).status_code == 403
    assert asking.post("/look", headers={"origin": origin}).status_code == 403


@pytest.mark.parametrize("origin", FOREIGN)
def test_foreign_pages_get_no_web_socket(asking: TestClient, origin: str) -> None:
    with (
        pytest.raises(WebSocketDisconnect) as closed,
        asking.websocket_connect(f"ws://{HOST}/talk", headers={"origin": origin, "host": HOST}),
    ):
        pass
    assert closed.value.code == 1008


def test_own_pages_get_one(asking: TestClient) -> None:
    with asking.websocket_connect(f"ws://{HOST}/talk", headers={**OWN, "host": HOST}) as socket:
        assert socket.receive_text() == "writer: False"


def test_too_much_is_refused_whether_its_length_is_told_or_not(asking: TestClient) -> None:
    asking.get(f"/look?token={TOKEN}")
    assert asking.post("/look", content=b"x" * BODY_BYTES, headers=OWN).status_code == 200
    assert asking.post("/look", content=b"x" * (BODY_BYTES + 1), headers=OWN).status_code == 413
    assert asking.post("/look", headers={**OWN, "content-length": "many"}).status_code == 413


def test_every_answer_forbids_what_is_not_the_page_s_own(asking: TestClient) -> None:
    for answer in (asking.get("/look"), asking.get("/look?token=wrong"), asking.get("/nowhere")):
        assert "default-src 'none'" in answer.headers["content-security-policy"]
        assert answer.headers["referrer-policy"] == "no-referrer"
        assert answer.headers["x-content-type-options"] == "nosniff"


@pytest.mark.finding("page 18")
def test_a_body_of_unknown_length_that_is_too_long_is_told(asker: httpx.Client) -> None:
    def pieces() -> Iterator[bytes]:
        for _ in range(40):
            yield b"x" * 4096

    assert asker.post("/send/put", content=pieces()).status_code == 413


@pytest.mark.finding("page 6", "page B8")
@pytest.mark.parametrize(
    "sent", [b"", b"GET / HTTP/1.1\r\nHost: 127", b"GET /link HTTP/1.1\r\nHost: {host}\r\n\r\nGET /"]
)
def test_half_a_request_is_let_go(steady: Site, monkeypatch: pytest.MonkeyPatch, sent: bytes) -> None:
    monkeypatch.setattr(patience, "HEAD_S", 0.05)
    with socket.create_connection(("127.0.0.1", steady.port), LONG_S) as half:
        half.sendall(sent.replace(b"{host}", f"127.0.0.1:{steady.port}".encode()))
        with suppress(ConnectionResetError):  # on a busy machine it was let go before it said anything
            while half.recv(65_536):
                pass


def connected_within(
    steady: Site, monkeypatch: pytest.MonkeyPatch, limit_s: float
) -> ClientConnection | None:
    """A web socket opened under this limit for requests; None if this machine was too busy for that."""
    monkeypatch.setattr(patience, "HEAD_S", limit_s)
    try:
        return connect(f"ws://127.0.0.1:{steady.port}/trace/live", max_size=None, open_timeout=LONG_S)
    except (InvalidMessage, ConnectionClosed, ConnectionError):
        return None


def test_a_web_socket_outlives_the_limit_for_requests(steady: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    limit_s = 0.05
    while (opened := connected_within(steady, monkeypatch, limit_s)) is None:
        limit_s *= 2
        assert limit_s < LONG_S
    with opened as web_socket:
        with socket.create_connection(("127.0.0.1", steady.port), LONG_S) as silent:
            assert silent.recv(1) == b""  # its limit, which began later, is over
        web_socket.send(json.dumps({"look": {"number": 7, "lines": []}, "ask": {"at": 0, "rows": 1}}))
        assert b'"look"' in web_socket.recv(LONG_S)
