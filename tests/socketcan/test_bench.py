"""The bench itself: which processes it takes for the servers of its programs."""

from __future__ import annotations

import os

from tests.socketcan.bench import Bench


def test_the_tests_own_process_is_no_server(bench: Bench) -> None:
    """Not even as a session's leader (`setsid pytest`, a container's first process) in the programs' folder."""
    child = os.fork()
    if child == 0:
        try:
            os.setsid()
            os.chdir(bench.home)
            os._exit(0 if bench.servers_wait() else 1)
        finally:
            os._exit(2)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
