"""A viewer that goes is let go, whatever comes at that moment."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from canwire.web.trace.feed import Feed

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
