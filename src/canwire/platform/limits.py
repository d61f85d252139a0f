"""The limit of open descriptors of a process."""

from __future__ import annotations

import contextlib
from typing import Any

_MANY = 10_240  # where the system names no limit
_SELECT_TAKES = 512  # sockets at a time on Windows: what Python builds FD_SETSIZE with


def descriptor_limit() -> int:
    """The number of descriptors that this process may have open; `raise_descriptor_limit` raises it."""
    resource = _resource()
    return _SELECT_TAKES if resource is None else int(resource.getrlimit(resource.RLIMIT_NOFILE)[0])


def raise_descriptor_limit() -> None:
    """Raise the limit to the most that the system allows this process without further rights."""
    resource = _resource()
    if resource is None:
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = max(soft, _MANY) if hard == resource.RLIM_INFINITY else hard
    with contextlib.suppress(OSError, ValueError):  # macOS says "infinite" and means less
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def _resource() -> Any:
    """The module `resource`, which Windows does not have."""
    try:
        import resource
    except ImportError:
        return None
    return resource
