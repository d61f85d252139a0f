"""`canwire web`: show the hub in a browser: boards, trace, sending, statistics and faults.

canwire web                      print an address that contains a token; only with it can the page be read and used
canwire web --viewers            other users of this machine may read without the token
canwire web --open               also open the page in the browser
canwire web --port 8080 --db car.dbc     at a fixed port; frames are decoded with this database

The page is served on the loopback address only and loads nothing from other machines. Ctrl-C and SIGTERM end the
server; the boards stay as they are. Needs canwire[web], and canwire[databases] for --db.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from html import escape
from pathlib import Path

from canwire import BadValue, ExtraMissing, epoch_ns
from canwire.commands.shared_hub import add_hub_argument, connected
from canwire.commands.shell.ending import signals_call


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "--port",
        type=int,
        default=None,
        metavar="N",
        help="listen at this port; 0: any free one (default: 7457, or any free one if that is in use)",
    )
    parser.add_argument(
        "--viewers", action="store_true", help="let other users of this machine read without the token"
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument(
        "--db",
        action="append",
        default=[],
        metavar="[BUS=]FILE",
        help="decode frames with this database, for all buses or for one; may be given several times",
    )
    add_hub_argument(parser)


@contextmanager
def leading_to(address: str) -> Iterator[str]:
    """Yield the URL of a file that redirects to `address`; only this user can read it, unlike arguments."""
    number, name = tempfile.mkstemp(suffix=".html")  # mode 0600
    try:
        with open(
            number, "w", encoding="utf-8", newline="\n"
        ) as file:  # closed: before that, no other program can read it on Windows
            file.write(f'<meta http-equiv="refresh" content="0;url={escape(address)}">')
        yield Path(name).as_uri()
    finally:
        os.unlink(name)


def run(arguments: argparse.Namespace) -> int:
    """Serve until SIGTERM or SIGINT. Raises BadValue for an invalid port or file, HubError without a hub."""
    if arguments.port is not None and not 0 <= arguments.port <= 65_535:
        raise BadValue(f"--port {arguments.port}: 0 to 65535")
    for path in arguments.db:
        if not os.path.isfile(path.partition("=")[2] or path):
            raise BadValue(f"--db {path}: there is no such file")
    try:
        from canwire.web.server import Site
    except ModuleNotFoundError as error:
        raise ExtraMissing(str(error.name), "web") from None
    with ExitStack() as closing:
        hub = connected(arguments, "web", closing)
        site = Site(hub, epoch_ns, port=arguments.port, databases=arguments.db, viewers=arguments.viewers)
        closing.callback(site.close)
        closing.enter_context(signals_call(site.stop))
        print(f"canwire web: {site.address}", flush=True)
        if arguments.open:
            webbrowser.open(closing.enter_context(leading_to(site.address)))
        site.run()
    return 0
