"""Closes a session of Zenoh's, also where the network has been cut."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from canwire.hub.links.network.session.settings import load_zenoh


def close(session: Any) -> None:
    """Close a session.

    Zenoh says goodbye to the other side, and raises its error after 10 s if a cut keeps it from doing so. The session
    is over then, too, and the other side notices the silence.
    """
    with contextlib.suppress(load_zenoh().ZError):
        session.close()


@contextlib.contextmanager
def closing(session: Any) -> Iterator[Any]:
    """Close this session at the end."""
    try:
        yield session
    finally:
        close(session)
