"""Connect to a hub: at an address, at the user's default address, or inside the program."""

from __future__ import annotations

import os
import re
import sys
from typing import TYPE_CHECKING

from canwire.errors import BadValue
from canwire.hub.handles.hub import Hub
from canwire.hub.links.calling import RemoteLink, somebody_listens
from canwire.hub.usual import default_address
from canwire.values.checks import instance
from canwire.values.mistakes.calls import answers_wrong_calls

if TYPE_CHECKING:
    from canwire.boards.config.configuration import Config
    from canwire.hub.protocol.link import Link

_NETWORK = "zenoh://"
_A_LINE = re.compile(r"v?can\d+|lin\d+|HW\d{6}(:\d+)?")


@answers_wrong_calls
def connect(
    address: str | None = None,
    *,
    time: str | None = None,
    config: str | os.PathLike[str] | Config | None = None,
    name: str | None = None,
    timed: bool | None = None,
) -> Hub:
    """The hub at `address`, else at CANWIRE_HUB, else at this user's default socket if a hub listens there.

    Else a hub in real time inside this process, shared by all such calls until the last of their hubs is closed.
    `time` ("real", "fast", "virtual", "lockstep") or `config` (a file's path, or a Config) always makes a new private
    hub inside this process. An address is a socket's path, or zenoh://REALM/HOST for a hub on another
    machine (docs/machines.md). `name` is shown to other programs beside each lease of this one. A hub is closed
    when neither it nor anything opened on it is referenced any more; `with` or `close` closes it earlier.

    `timed`: this program takes part in lockstep time on a hub of `canwire serve --time lockstep`. None: it does so if
    CANWIRE_TIMED is 1, and its threads then take turns as within `canwire.in_time`. The call returns at the program's
    first turn. Turns are ordered by name: CANWIRE_NAME if that is set, else `name`.

    Raises HubLost if no hub listens at a given address, BadConfig for a bad configuration, WrongState for `timed` if
    the hub is not in lockstep time.
    """
    name = name or os.environ.get("CANWIRE_NAME") or _name_of_program()
    usual = timed is None and time is None and config is None and _usually_timed()
    return _taking_part(_connected(address, time, config, name), name, timed or usual, threads=usual)


def _taking_part(hub: Hub, name: str, timed: bool, *, threads: bool) -> Hub:
    if timed:
        try:
            name = os.environ.get("CANWIRE_NAME") or name
            if not threads:
                hub.keep_time(name)
                return hub
            from canwire.threads.outset import own_company, take_turns  # what no other program has need of

            hub.keep_time(name, own_company())
            take_turns(hub)
        except BaseException:
            hub.close()
            raise
    return hub


def _connected(
    address: str | None, time: str | None, config: str | os.PathLike[str] | Config | None, name: str
) -> Hub:
    if time is not None or config is not None:
        if address is not None:
            raise BadValue(f"the hub at {address} has its own time and boards: leave time and config out")
        from canwire.hub.in_process import fresh_link

        return _hub(fresh_link("real" if time is None else time, config, name))
    address = address or os.environ.get("CANWIRE_HUB")
    if address:
        return _hub(_link_to(address, name))
    usual = default_address()
    if somebody_listens(usual):
        return _hub(RemoteLink(usual, name))
    from canwire.hub.in_process import (
        common_link,
    )  # boards and all, which who uses a shared hub has no need of

    return _hub(common_link(name))


def _usually_timed() -> bool:
    """Whether CANWIRE_TIMED is 1; raises BadValue for other values than 1, 0 and ""."""
    said = os.environ.get("CANWIRE_TIMED", "")
    if said not in ("", "0", "1"):
        raise BadValue(f"CANWIRE_TIMED={said!r}: 1 to keep one time with other programs, 0 or nothing else")
    return said == "1"


def _link_to(address: str, name: str) -> Link:
    instance("address", address, str)
    if not address.startswith(_NETWORK):
        if "://" in address:
            raise BadValue(
                f"address {address!r}: a socket's path, or zenoh://REALM/HOST for a hub on another machine"
            )
        if _A_LINE.fullmatch(address) and not os.path.exists(address):
            raise BadValue(
                f"address {address!r}: that looks like a line, and this is where its hub listens; leave it out, and "
                f"find the line by canwire.find_lines(hub, {address!r})"
            )
        return RemoteLink(address, name)
    from canwire.hub.links.network.client import NetworkLink  # needs an extra

    return NetworkLink(address, name)


def _hub(link: Link) -> Hub:
    try:
        return Hub(link)
    except BaseException:
        link.close()
        raise


def _name_of_program() -> str:
    return os.path.basename(sys.argv[0] if sys.argv else "") or "python"
