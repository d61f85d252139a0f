"""Where the assemblies of this run are, which take a second to compile: once, not in each worker."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import pytest

from canwire.native import dotnet


def state_of_this_run(made: pytest.TempPathFactory) -> Path:
    """For XDG_STATE_HOME: canwire finds the assemblies there, compiled by whichever worker came first."""
    base = made.getbasetemp()
    home = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "dotnet-state"
    home.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch, open(home / "lock", "w") as lock:
        patch.setenv("XDG_STATE_HOME", str(home))
        fcntl.flock(lock, fcntl.LOCK_EX)
        dotnet.assembly_directory()
    return home
