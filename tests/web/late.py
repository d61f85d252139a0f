"""A page whose server and browser are slow: `python -m pytest -p tests.web.late tests/web`.

Each answer, message and picture is late by a random time, so that whatever may come in another order does so. Load on
the machine shows such an order once in hundreds of runs; this showed in ten runs of each test what README's command
had shown once in five (docs/tests.md). A test that fails here waits for something that was there before, or the page
takes an answer for another one.
"""

from __future__ import annotations

from typing import Any

import pytest

_SCRIPT = """
const late = (most_ms) => new Promise((go) => setTimeout(go, Math.random() * most_ms));

const { fetch } = window;
window.fetch = async (...asked) => {
    await late(200);
    const answer = await fetch(...asked);
    await late(200);
    return answer;
};
const { send } = XMLHttpRequest.prototype;
XMLHttpRequest.prototype.send = async function (...body) {
    await late(400);
    send.apply(this, body);
};

const nextPicture = window.requestAnimationFrame.bind(window);
window.requestAnimationFrame = (draw) => late(50).then(() => nextPicture(draw));

// What goes over a web socket stays in its order.
const inOrder = (before, do_it) => (before ?? Promise.resolve()).then(() => late(Math.random() * 100)).then(do_it);
const { send: sendMessage } = WebSocket.prototype;
WebSocket.prototype.send = function (message) {
    this.sent = inOrder(this.sent, () => sendMessage.call(this, message));
};
Object.defineProperty(WebSocket.prototype, "onmessage", {
    set(hear) {
        let heard = null;
        this.addEventListener("message", (event) => { heard = inOrder(heard, () => hear(event)); });
    },
});
"""


def pytest_configure(config: pytest.Config) -> None:
    """Tabs of all browsers begin with the script."""
    from playwright.sync_api import Browser, BrowserContext

    new_context = Browser.new_context

    def late(browser: Browser, **options: Any) -> BrowserContext:
        context = new_context(browser, **options)
        context.add_init_script(_SCRIPT)
        return context

    Browser.new_context = late  # type: ignore[method-assign]
