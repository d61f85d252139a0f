"""A viewer that goes is let go, whatever comes at that moment."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any, cast

import pytest
from starlette.websockets import WebSocketDisconnect

from canwire import BadValue
from canwire.web.trace.feed import Feed
from canwire.web.trace.look import Look
from tests.cases import each
from tests.hubs import LONG_S

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

pytestmark = pytest.mark.conforms("N-53")


async def forgotten() -> None:
    """The task of a feed whose viewer has gone ends at whichever turn of the loop its cancellation comes."""
    nothing: Any = None
    for turns in range(6):
        feed = Feed(nothing, nothing)
        speaking = asyncio.create_task(feed._speak())
        for _ in range(3):
            await asyncio.sleep(0)
        feed._news.set()
        for _ in range(turns):
            await asyncio.sleep(0)
        speaking.cancel()
        for _ in range(20):
            await asyncio.sleep(0)
        assert speaking.cancelled(), turns


def test_the_task_of_a_viewer_that_has_gone_ends_though_news_come_meanwhile() -> None:
    with ThreadPoolExecutor(1) as pool:  # this thread's event loop may be the browser's
        pool.submit(asyncio.run, forgotten()).result()


class View:
    """What a viewer looks at, and whether that was ended."""

    def __init__(self, look: Look) -> None:
        self.look = look
        self.listened = self.left = False

    def listen(self, grown: object) -> None:
        self.listened = True

    def leave(self) -> None:
        self.listened, self.left = False, True


class Viewer:
    """A web socket on which somebody asks for one view after the other, and leaves at the signal."""

    def __init__(self, *sources: str) -> None:
        self._looks = [{"number": 1, "lines": [], "source": source} for source in sources]
        self.leaves = asyncio.Event()
        self.seen = asyncio.Event()
        self.closed = False

    async def accept(self) -> None:
        """Whoever wants may look."""

    async def close(self) -> None:
        self.closed = True

    async def receive_text(self) -> str:
        if not self._looks:
            await self.leaves.wait()
            raise WebSocketDisconnect
        await self.seen.wait()
        self.seen.clear()
        return json.dumps({"look": self._looks.pop(0)})


async def closed_meanwhile() -> None:
    views: list[View] = []
    viewer = Viewer("", "log-1")
    viewer.seen.set()
    loop = asyncio.get_running_loop()

    def viewing(look: Look, *_: object) -> Any:
        if look.source:
            raise BadValue("log-1: this log is not open any more")
        views.append(View(look))
        loop.call_soon_threadsafe(viewer.seen.set)
        return views[0]

    await Feed(cast("WebSocket", viewer), viewing).run()
    assert viewer.closed
    assert views[0].left
    assert not views[0].listened


async def gone_meanwhile() -> None:
    viewer = Viewer("")
    viewer.seen.set()
    loop = asyncio.get_running_loop()
    gone = threading.Event()
    views: list[View] = []

    async def go() -> None:
        viewer.leaves.set()
        for _ in range(20):
            await asyncio.sleep(0)
        gone.set()

    def viewing(look: Look, *_: object) -> Any:
        asyncio.run_coroutine_threadsafe(go(), loop)
        assert gone.wait(LONG_S)
        views.append(View(look))
        return views[0]

    await Feed(cast("WebSocket", viewer), viewing).run()
    assert [view.left for view in views] == [True]


@each("story", [closed_meanwhile, gone_meanwhile])
def test_the_view_of_a_viewer_that_has_gone_ends(story: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Else its lines are recorded for ever: the log that is looked at next is closed, or the view is not ready yet."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, story()).result()
