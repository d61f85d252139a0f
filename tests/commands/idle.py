"""When a Textual window has nothing more to do, however busy the machine is.

Textual's pilot takes a process for idle that uses little of the processor, which on a busy machine it does in the
middle of its work. The event loop knows better: a window is idle when its timers have had their turn, and no call is
ready after that.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import ExitStack, asynccontextmanager
from typing import Any
from unittest.mock import patch

REDRAWN_S = 0.02  # windows redraw 60 times a second; their other timers change nothing that a test is about
ROUNDS = 2  # what is done at one redrawing may ask for another one


async def wait_for_idle(*_: float) -> None:
    """Stand in for the pilot's function of this name, which takes a least and a longest time."""
    loop = asyncio.get_running_loop()
    for _round in range(ROUNDS):
        await asyncio.sleep(
            REDRAWN_S
        )  # timers that are due before its end run before it, however late they are
        while getattr(loop, "_ready"):  # noqa: B009 - asyncio has no public name for it
            await asyncio.sleep(0)


@asynccontextmanager
async def piloted(app: Any, **options: Any) -> AsyncIterator[Any]:
    """Textual's `app.run_test(**options)`, whose pilot waits until the window is idle."""
    with ExitStack() as stack:
        for user in ("app", "pilot"):
            stack.enter_context(patch(f"textual.{user}.wait_for_idle", wait_for_idle))
        async with app.run_test(**options) as pilot:
            await pilot.pause()
            yield pilot
