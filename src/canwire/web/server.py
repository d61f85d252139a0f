"""The server's process: listens on the loopback address until it is stopped."""

from __future__ import annotations

import contextlib
import secrets
import socket
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import uvicorn

from canwire import BadValue
from canwire.web.app import make_app
from canwire.web.databases.loaded import Databases
from canwire.web.desk import Desk
from canwire.web.link import HubLink, connect_again
from canwire.web.patience import PatientProtocol
from canwire.web.views import VIEWS

if TYPE_CHECKING:
    from canwire import Hub

LOOPBACK = "127.0.0.1"
USUAL_PORT = 7457
_GRACE_S = 1  # for answers that are under way when it ends
_MESSAGE_BYTES = 131_072


class Site:
    """A page that can be served: `address` contains the token, `run` blocks until `stop`.

    `port` 0 is any free port, None the default port if it is free (a browser stores its data by port).
    `databases` are files for Databases. With `viewers` any user of this machine may watch without the token.
    """

    def __init__(
        self,
        hub: Hub,
        epoch_ns: Callable[[Hub], int],
        *,
        port: int | None = 0,
        databases: Iterable[str] = (),
        viewers: bool = False,
    ) -> None:
        opened = Databases(databases)
        self._socket = _usual() if port is None else _listening(port)
        self.port = int(self._socket.getsockname()[1])
        self.token = secrets.token_urlsafe(18)
        self.link = HubLink(connect_again(hub))
        self.desk = Desk(self.link, VIEWS, epoch_ns, opened)
        hosts = [f"{name}:{self.port}" for name in (LOOPBACK, "localhost")]
        try:
            self.app = make_app(self.desk, self.token, hosts, self.port, viewers=viewers)
        except BaseException:
            self.close()
            raise
        self._server = uvicorn.Server(
            uvicorn.Config(
                self.app,
                log_level="warning",
                access_log=False,
                http=PatientProtocol,
                ws="websockets-sansio",
                ws_max_size=_MESSAGE_BYTES,
                ws_per_message_deflate=False,  # on the loopback address it costs and saves nothing
                lifespan="off",
                timeout_graceful_shutdown=_GRACE_S,
            )
        )

    @property
    def url(self) -> str:
        """The address for viewers, which may only read."""
        return f"http://{LOOPBACK}:{self.port}/"

    @property
    def address(self) -> str:
        """The address with the token, which allows changes."""
        return f"{self.url}?token={self.token}"

    def run(self) -> None:
        """Serve until `stop`; in the main thread, also until SIGINT or SIGTERM."""
        try:
            with contextlib.suppress(KeyboardInterrupt):  # uvicorn raises it again, once all is closed
                self._server.run(sockets=[self._socket])
        finally:
            self.close()

    def stop(self) -> None:
        """Make `run` return; may be called from any thread."""
        self._server.should_exit = True

    def close(self) -> None:
        """Close the port and the connection to the hub; a second call does nothing."""
        self._socket.close()
        self.desk.closing.close()
        self.link.close()


def _usual() -> socket.socket:
    try:
        return _listening(USUAL_PORT)
    except BadValue:  # somebody has it
        return _listening(0)


def _listening(port: int) -> socket.socket:
    listening = socket.socket(
        proto=socket.IPPROTO_TCP
    )  # else asyncio leaves Nagle's algorithm on: 40 ms an answer
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((LOOPBACK, port))
        listening.listen()  # early connections wait until the server runs
    except OSError as error:
        listening.close()
        raise BadValue(f"--port {port}: {error.strerror}; another one, or 0 for any that is free") from None
    return listening
