"""Work with a handle in a separate thread, so that Ctrl-C and SIGTERM never hit in the middle of it."""

from __future__ import annotations

import threading
from collections.abc import Callable

_LOOK_S = 0.5  # Windows tells of Ctrl-C between two waits only


def work(
    call: Callable[[], object], stop: Callable[[], object], look: Callable[[], object] = lambda: None
) -> None:
    """Run `call` to its end and raise what it raises. Ctrl-C calls `stop`, waits for the end and is raised then.

    `look` is called every half second meanwhile. What `call` raises after `stop` is dropped.
    """
    ended = threading.Event()
    errors: list[BaseException] = []

    def run() -> None:
        try:
            call()
        except BaseException as error:
            errors.append(error)
        finally:
            ended.set()

    thread = threading.Thread(target=run, daemon=True)
    try:
        thread.start()
        while not ended.wait(_LOOK_S):
            look()
    except KeyboardInterrupt:
        stop()
        while thread.is_alive() and not ended.wait(_LOOK_S):
            pass
        raise
    if errors:
        raise errors[0]
