"""Processes that multiprocessing spawns, warm: what such a process imports before it can begin is there already.

All else is as it was: its words, descriptors and pipes, what is pickled for it, and how it ends.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from multiprocessing import resource_tracker, util
from typing import Any
from unittest import mock

__all__ = ["spawned_warm"]

if hasattr(os, "fork"):
    import sys
    from multiprocessing import popen_spawn_posix

    from tests import warm

    class _Popen(popen_spawn_posix.Popen):
        """What a process of multiprocessing's is started and waited for by."""

        def _launch(self, process_obj: Any) -> None:
            resource_tracker.ensure_running()  # which would be started in the same way
            with mock.patch.object(util, "spawnv_passfds", self._started):
                super()._launch(process_obj)

        def _started(self, _python: object, words: Sequence[Any], descriptors: Sequence[int]) -> int:
            own = words[words.index("-c") :]
            self._program = warm.Popen([sys.executable, *own], pass_fds=descriptors)
            return self._program.pid

        def poll(self, flag: int = os.WNOHANG) -> int | None:
            self.returncode = self._program.poll() if flag else self._program.wait()
            return self.returncode

    @contextmanager
    def spawned_warm() -> Iterator[None]:
        """Until its end, this process spawns warm ones."""
        with mock.patch.object(popen_spawn_posix, "Popen", _Popen):
            yield

else:
    spawned_warm = nullcontext
