"""The default address and the default configuration of a user's hub."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from canwire.places import runtime_directory
from canwire.places import state_directory as state_directory

if TYPE_CHECKING:
    from canwire.boards.config.configuration import Config

_CONFIG_HERE = "canwire.toml"


def default_address() -> str:
    """The path of this user's default socket."""
    return os.path.join(runtime_directory(), "canwire.sock")


def usual_config(given: str | os.PathLike[str] | Config | None = None) -> Config:
    """The given configuration, else CANWIRE_CONFIG's file, else canwire.toml here, else the default; BadConfig."""
    from canwire.boards.config.configuration import Config  # every kind of board: not for who only asks where

    if isinstance(given, Config):
        return given
    path = (
        given or os.environ.get("CANWIRE_CONFIG") or (_CONFIG_HERE if os.path.exists(_CONFIG_HERE) else None)
    )
    return Config.default() if path is None else Config.load(os.fspath(path))
