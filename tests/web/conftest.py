"""A page on a hub of its own, asked by httpx or shown in Debian's chromium."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from unittest import mock

import pytest

import canwire
from canwire import epoch_ns
from tests.hubs import LONG_S, free_port, served_here, serving
from tests.missing import find_browser

httpx = pytest.importorskip("httpx2")
pytest.importorskip("starlette")
pytest.importorskip("uvicorn")

from canwire.web import server  # noqa: E402
from canwire.web.link import NAME  # noqa: E402
from canwire.web.server import Site  # noqa: E402

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Locator, Page, ViewportSize

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--renderer-process-limit=1",  # these two spare a fifth of what a page costs
    "--in-process-gpu",
    "--js-flags=--no-opt --single-threaded",  # pages that live for a second are not worth optimizing
]


SCREEN: ViewportSize = {"width": 1280, "height": 720}


@cache
def usual_port() -> int:
    """The port of one page after another: a browser keeps their scripts, a third of what a load costs, by address."""
    return free_port()


@contextmanager
def served_site(address: str, databases: Iterable[str] = (), *, viewers: bool = True) -> Iterator[Site]:
    """The page of the hub at this address, served by a thread of this process; everybody may look."""
    with canwire.connect(address, name=NAME) as hub:
        with mock.patch.object(server, "USUAL_PORT", usual_port()):  # each worker has another one
            site = Site(hub, epoch_ns, port=None, databases=databases, viewers=viewers)
        thread = threading.Thread(target=site.run)
        thread.start()
        try:
            yield site
        finally:
            site.stop()
            thread.join(LONG_S)
            assert not thread.is_alive()


@pytest.fixture
def home(tmp_path: Path) -> Path:
    """Where `hub` has its socket: whoever ends that hub can start another one there."""
    return tmp_path


@pytest.fixture
def hub_address(home: Path) -> Iterator[str]:
    """A hub of this test's own, with the usual boards, in real time."""
    with served_here(home, time="real") as made:
        yield made


@pytest.fixture
def hub(hub_address: str) -> Iterator[canwire.Hub]:
    """Another program on the same hub."""
    with canwire.connect(hub_address, name="test") as made:
        yield made


@pytest.fixture
def site(hub_address: str) -> Iterator[Site]:
    with served_site(hub_address) as made:
        yield made


def caller(site: Site, *, follow_redirects: bool = False) -> httpx.Client:
    """Without certificates, which take 40 ms to load: the page speaks plain HTTP."""
    return httpx.Client(base_url=site.url, follow_redirects=follow_redirects, timeout=LONG_S, verify=False)


@contextmanager
def somebody(site: Site) -> Iterator[httpx.Client]:
    """Somebody with the token."""
    with caller(site, follow_redirects=True) as made:
        assert made.get(f"/?token={site.token}").status_code == 200
        yield made


@pytest.fixture(scope="session")
def steady(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A page for all tests that leave it and its hub as they are."""
    with serving(tmp_path_factory.mktemp("hub"), time="real") as made, served_site(made.address) as site:
        yield site


@pytest.fixture(scope="session")
def asker(steady: Site) -> Iterator[httpx.Client]:
    """Somebody with the token there."""
    with somebody(steady) as made:
        yield made


@pytest.fixture
def client(site: Site) -> Iterator[httpx.Client]:
    with somebody(site) as made:
        yield made


@pytest.fixture
def viewer(site: Site) -> Iterator[httpx.Client]:
    """Somebody without the token."""
    with caller(site) as made:
        yield made


@contextmanager
def opened_browser() -> Iterator[Browser]:
    """Debian's chromium; tests that need it are skipped where it or playwright is missing.

    While it is open there is an event loop in this thread, which `asyncio.run` and a second browser would meet.
    """
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = find_browser()
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=chromium, args=FLAGS)
        _blank(browser)
        yield browser
        browser.close()


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """One for all tests of this folder in a worker. A test elsewhere that imported this fixture would keep it open."""
    with opened_browser() as made:
        yield made


EMPTY = "about:blank"


@contextmanager
def tab(browser: Browser, address: str, **options: object) -> Iterator[Page]:
    """A tab with cookies of its own. Whatever goes wrong in its scripts fails the test.

    The browser's first tab serves test after test: another one costs a second of processor time. It is emptied between
    them. A tab beside it, or one with options, is a new one.
    """
    first = browser.contexts[0].pages[0]
    page = first if first.url == EMPTY and not options else _blank(browser, **options)
    faults: list[str] = []
    with (
        told(page, "pageerror", lambda error: faults.append(str(error))),
        told(page, "console", lambda said: faults.append(said.text) if said.type == "error" else None),
    ):
        page.goto(address)
        try:
            yield page
        except Exception as failure:
            failure.add_note(f"The page's own faults until then: {faults}")
            raise
        finally:
            if page is first:
                _empty(page)
            else:
                page.context.close()
    assert [fault for fault in faults if "Failed to load resource" not in fault] == []


@contextmanager
def told(page: Page, event: str, call: Callable[[Any], object]) -> Iterator[None]:
    """Call this at each such event of the page, so long."""
    page.on(event, call)
    try:
        yield
    finally:
        page.remove_listener(event, call)


def _blank(browser: Browser, **options: object) -> Page:
    context = browser.new_context(**{"locale": "en-GB", "viewport": SCREEN, **options})
    context.set_default_timeout(LONG_S * 1000)
    return context.new_page()


def _empty(page: Page) -> None:
    """As a new one is: nothing is shown, kept or asked for."""
    origin = page.evaluate("location.origin")
    page.unroute_all()
    page.goto(EMPTY)
    page.context.clear_cookies()
    session = page.context.new_cdp_session(page)
    session.send("Storage.clearDataForOrigin", {"origin": origin, "storageTypes": "all"})
    session.detach()
    page.set_viewport_size(SCREEN)
    page.emulate_media(color_scheme="light")


def at(site: Site, view: str) -> str:
    """The address of this view, with the token: each load of a page costs half a second of processor time."""
    return f"{site.url}{view}?token={site.token}"


@pytest.fixture
def view() -> str:
    """Which one `page` shows; modules have their own."""
    return "boards"


@pytest.fixture
def page(browser: Browser, site: Site, view: str) -> Iterator[Page]:
    """A tab of somebody with the token."""
    with tab(browser, at(site, view)) as made:
        yield made


def nameless_controls(page: Page) -> list[str]:
    """Controls that a screen reader has no name for."""
    controls = page.locator("button, select, input:not([type=hidden]), a")
    found: list[str] = controls.evaluate_all(
        "all => all.filter(one => !(one.textContent.trim() || one.ariaLabel || one.labels?.length || one.title))"
        ".map(one => one.outerHTML)"
    )
    return found


def counts(found: Locator, number: int) -> None:
    """The page comes to show so many of them, in its own time."""
    from playwright.sync_api import expect

    expect(found).to_have_count(number)


def holds(field: Locator, value: str) -> None:
    """The field comes to have this value, in the page's own time."""
    from playwright.sync_api import expect

    expect(field).to_have_value(value)
