"""Closes a connection on which no complete request arrives: half requests would use up the server's descriptors."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.auto import AutoHTTPProtocol

HEAD_S = 10.0  # for a request's head; its body has the gate's BODY_S


class PatientProtocol(AutoHTTPProtocol):  # type: ignore[valid-type, misc]  # one of two classes, as installed
    """uvicorn's protocol with a time limit for the head of each request."""

    _limit: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self._limit = self.loop.call_later(HEAD_S, self._expire)

    def data_received(self, data: bytes) -> None:
        if self._limit is None and self._waits():
            self._limit = self.loop.call_later(HEAD_S, self._expire)
        super().data_received(data)
        if not self._waits():
            self._settle()

    def connection_lost(self, exc: Exception | None) -> None:
        self._settle()
        super().connection_lost(exc)

    def _waits(self) -> bool:
        """Whether no request is in progress, and the connection has not become a web socket, which has another
        protocol."""
        if self.transport.get_protocol() is not self:
            return False
        return self.cycle is None or self.cycle.response_complete

    def _settle(self) -> None:
        if self._limit is not None:
            self._limit.cancel()
            self._limit = None

    def _expire(self) -> None:
        self._limit = None
        if self._waits():
            self.transport.close()
