"""Calls over a network that may drop the call or its answer: a call is repeated until its answer has arrived.

A call is first sent as a message, answered by another one. It is repeated as a query, which costs more, but reaches
the hub also where no message does.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Any

from canwire.errors import HubLost
from canwire.hub.links.network import wire
from canwire.hub.links.network.calls import Answered, Asked, Call, encode
from canwire.hub.links.network.pump import Pump
from canwire.hub.links.network.session.callback import direct
from canwire.hub.links.network.session.settings import load_zenoh
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.messages import Hello

_QUERY_S = 60.0  # Zenoh forgets a query after so long; one that waits on is asked again
_FIRST_S, _LONGEST_S = (
    0.25,
    5.0,
)  # before a call is asked again: its query, or the answer, may have been dropped
_LOOK_S = 0.1


class Asker:
    """Sends calls by `send`, or as queries of this key, whose replies `answered` gets.

    A call raises HubLost after its `silence_s` without any message from the hub.
    """

    def __init__(
        self,
        session: Any,
        key: str,
        answered: Callable[[Any], None],
        send: Callable[[bytes], object],
        pump: Pump,
        address: str,
    ) -> None:
        zenoh = load_zenoh()
        self._session = session
        self._error = zenoh.ZError
        self._answered = direct(answered)
        self._send = send
        self._drop = zenoh.CongestionControl.DROP
        self._key = key
        self._pump = pump
        self._address = address

    def insist(self, call: Call, asked: Asked, silence_s: float) -> tuple[Answer, Answered]:
        """Repeat the call, each time with a new stamp, until it is answered; HubLost after too long a silence."""
        began_s = time.monotonic()
        again_s, pause_s = began_s, _FIRST_S
        while True:
            now_s = time.monotonic()
            if now_s >= again_s:
                asked.stamp = self._pump.clock.stamp(time.monotonic_ns())
                if again_s == began_s and not isinstance(call.request, Hello):
                    self._send(wire.call(encode(asked)))
                else:
                    self._query(encode(asked))
                again_s, pause_s = now_s + pause_s, min(2 * pause_s, _LONGEST_S)
            with contextlib.suppress(TimeoutError):
                return call.answered.result(min(_LOOK_S, max(0.0, again_s - time.monotonic())))
            self._heard_since(began_s, silence_s)

    def await_arrival(self, said: Answered, silence_s: float) -> None:
        """Wait for everything that was sent before this answer."""
        began_s = time.monotonic()
        while not self._pump.await_arrival(said.positions, silence_s):
            self._heard_since(began_s, silence_s)

    def _heard_since(self, began_s: float, silence_s: float) -> None:
        silent_s = time.monotonic() - max(began_s, self._pump.heard_ns / 1e9)
        if silent_s > silence_s:
            raise HubLost(
                f"no message from {self._address} for {silent_s:.1f} s; channels stay open, and continue "
                "if the network comes back"
            )

    def _query(self, asked: bytes) -> None:
        with contextlib.suppress(self._error):  # no connection at the moment
            self._session.get(
                self._key,
                self._answered,
                payload=asked,
                timeout=_QUERY_S,
                congestion_control=self._drop,
                express=True,
            )
