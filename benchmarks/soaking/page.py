"""A viewer of the page: `python page.py ADDRESS`. It asks for views, and hears the trace's socket.

When its input ends, it prints a line of JSON: pages, messages of the socket, and what was no page.
"""

from __future__ import annotations

import contextlib
import json
import select
import sys
import threading
import urllib.error
import urllib.request
from http.cookiejar import CookieJar
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

_VIEWS = ("/", "/trace", "/trace/lines", "/statistics", "/send", "/cancheck", "/panels")
_LINE = "HW11:0"
_PAUSE_S = 0.5
_PATIENCE_S = 60.0


class Viewer:
    """Opens the address that was printed, as a browser does: its cookie is sent with all else."""

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        self.origin = f"{parts.scheme}://{parts.netloc}"
        self._jar = CookieJar()
        self._opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(self._jar))
        self.pages = self.messages = 0
        self.wrong: list[str] = []
        self.look(address)
        cookie = "; ".join(f"{one.name}={one.value}" for one in self._jar)
        self._live = connect(
            f"ws://{parts.netloc}/trace/live", origin=self.origin, additional_headers={"Cookie": cookie}, max_size=None  # type: ignore[arg-type]
        )  # fmt: skip
        self._thread = threading.Thread(target=self._hear, daemon=True)
        self._thread.start()

    def look(self, address: str) -> None:
        try:
            with self._opener.open(address, timeout=_PATIENCE_S) as answer:
                answer.read()
            self.pages += 1
        except (urllib.error.URLError, OSError) as error:
            self.wrong.append(f"{address}: {error}")

    def _hear(self) -> None:
        """Its newest rows, asked for whenever the last ones have come."""
        ask = {"at": -1, "rows": 40}
        with contextlib.suppress(ConnectionClosed):
            self._live.send(json.dumps({"look": {"number": 1, "lines": [_LINE]}, "ask": ask}))
            for _ in self._live:
                self.messages += 1
                self._live.send(json.dumps({"ask": ask}))

    def end(self) -> None:
        self._live.close()
        self._thread.join()


def main() -> None:
    viewer = Viewer(sys.argv[1])
    print("at it", flush=True)
    number = 0
    while not select.select([0], [], [], _PAUSE_S)[0]:
        viewer.look(viewer.origin + _VIEWS[number % len(_VIEWS)])
        number += 1
    viewer.end()
    print(
        json.dumps({"pages": viewer.pages, "messages": viewer.messages, "wrong": viewer.wrong[:5]}),
        flush=True,
    )


if __name__ == "__main__":
    main()
