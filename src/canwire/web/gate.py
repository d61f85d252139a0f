"""Access rules, which are checked before a view gets a request.

The server listens on the loopback address, where every user and every web page of this machine can reach it. So:
only requests to its own names pass (a foreign name that resolves to 127.0.0.1 does not), only its own pages may
send (Origin), and every request needs the token of the address that was printed; with `viewers`, requests that only
read need none. A cookie keeps the token; browsers do not send it with requests of other sites.
"""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Iterable, Mapping
from html import escape
from http.cookies import CookieError, SimpleCookie
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

BODY_BYTES = 65_536
BODY_S = 30.0  # between two pieces of a body
READS = ("GET", "HEAD")
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)


class Gate:
    """Wraps an application; `request.scope["writer"]` says whether the request has the token.

    `uploads` are paths with the bytes that may be sent there; elsewhere it is BODY_BYTES.
    """

    def __init__(
        self,
        app: ASGIApp,
        token: str,
        hosts: Iterable[str],
        port: int,
        uploads: Mapping[str, int] | None = None,
        *,
        viewers: bool = False,
    ) -> None:
        self._app = app
        self._token = token
        self._hosts = frozenset(hosts)
        self._uploads = uploads or {}
        self._viewers = viewers
        self.cookie = f"canwire-token-{port}"  # cookies do not tell ports apart

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        answer = self._refused(scope, headers) or self._let_in(scope, headers)
        if answer is None:
            limited = _Limited(receive, self._most(scope)) if scope["type"] == "http" else receive
            await self._app(scope, limited, _guarded(send))
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": ""})
        else:
            await answer(scope, receive, _guarded(send))

    def _refused(self, scope: Scope, headers: Headers) -> Response | None:
        host = headers.get("host", "")
        if host not in self._hosts:
            return PlainTextResponse(f"{host!r} is not a name of this server", 421)
        origin = headers.get("origin")
        if origin is not None and origin.partition("://")[::2] not in (("http", host),):
            return PlainTextResponse(f"pages of {origin} may not ask here", 403)
        length, most = headers.get("content-length", "0"), self._most(scope)
        if not length.isdecimal() or int(length) > most:
            return PlainTextResponse(f"at most {most} bytes", 413)
        return None

    def _most(self, scope: Scope) -> int:
        return self._uploads.get(scope["path"], BODY_BYTES)

    def _let_in(self, scope: Scope, headers: Headers) -> Response | None:
        """Check a request, and set `scope["writer"]`; returns None if it is allowed, else the answer."""
        query = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        given = next((value for name, value in query if name == "token"), None)
        if given is not None:
            if not self._right(given):
                return PlainTextResponse("wrong token: take the address that `canwire web` printed", 403)
            if scope["type"] == "http":
                elsewhere = headers.get("sec-fetch-site") == "cross-site"
                return self._welcome(scope["path"], [pair for pair in query if pair[0] != "token"], elsewhere)
        scope["writer"] = given is not None or self._right(self._kept(headers))
        if not scope["writer"] and not self._viewers:
            return PlainTextResponse("only who has the address that “canwire web” printed may look here", 403)
        if scope["type"] == "http" and scope["method"] not in READS and not scope["writer"]:
            return PlainTextResponse("only viewers with the token may change anything", 403)
        return None

    def _welcome(self, path: str, query: list[tuple[str, str]], elsewhere: bool) -> Response:
        """Store the token in a cookie, and redirect to the address without it, so that histories and screenshots do not
        show it.

        A browser that comes from `elsewhere`, such as the file of `--open`, does not send a strict cookie with a
        redirected
        request; it sends the cookie with a request that a page of this server causes.
        """
        path = "/" + path.lstrip("/")  # //other.example would lead elsewhere
        target = path + (f"?{urlencode(query)}" if query else "")
        answer: Response = RedirectResponse(target, 303)
        if elsewhere:
            answer = HTMLResponse(f'<meta http-equiv="refresh" content="0;url={escape(target)}">')
        answer.set_cookie(self.cookie, self._token, httponly=True, samesite="strict")
        return answer

    def _kept(self, headers: Headers) -> str:
        try:
            kept = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return ""
        return kept.value if kept is not None else ""

    def _right(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self._token.encode())


class _Limited:
    """Limits the body of a request without a Content-Length: too many bytes, or a pause, count as a disconnection."""

    def __init__(self, receive: Receive, most: int) -> None:
        self._receive = receive
        self._left = most
        self._whole = False

    async def __call__(self) -> Message:
        if self._whole:
            return await self._receive()
        try:
            async with asyncio.timeout(BODY_S):
                message = await self._receive()
        except TimeoutError:
            return {"type": "http.disconnect"}
        self._whole = not message.get("more_body", False)
        self._left -= len(message.get("body", b""))
        return {"type": "http.disconnect"} if self._left < 0 else message


def _guarded(send: Send) -> Send:
    """Add headers to every answer that forbid foreign content, framing and guessing of types."""

    async def guarded(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.setdefault("content-security-policy", _POLICY)
            headers.setdefault("cache-control", "no-cache")
            headers["x-content-type-options"] = "nosniff"
            headers["referrer-policy"] = "no-referrer"
            headers["cross-origin-resource-policy"] = "same-origin"
        await send(message)

    return guarded
