"""What all views have in common: theme, language, keys, viewers without the token, nothing from elsewhere."""

from __future__ import annotations

import socket
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urljoin, urlsplit

import pytest

from canwire.web.server import Site
from canwire.web.views import VIEWS
from canwire.web.words import HERE
from tests.web.conftest import EMPTY, counts, nameless_controls, tab, told

if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser, Page, Route

pytestmark = pytest.mark.conforms("PG-13")


@pytest.fixture
def site(steady: Site) -> Site:
    return steady


NAMES = [view.name for view in VIEWS]


def contrast(one: str, other: str) -> float:
    """WCAG 2.1's contrast ratio of two colours as browsers tell them: "rgb(1, 2, 3)"."""

    def luminance(colour: str) -> float:
        parts = [int(part) / 255 for part in colour[4:-1].split(",")]
        red, green, blue = (
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
        )
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_quiet_text_can_be_read_in_both_themes(browser: Browser, site: Site) -> None:
    with tab(browser, site.url) as page:
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.reload()
            hint = page.locator(".hint").first
            ink = hint.evaluate("one => getComputedStyle(one).color")
            paper = page.locator("html").evaluate("one => getComputedStyle(one).backgroundColor")
            assert contrast(ink, paper) >= 4.5, scheme  # WCAG 2.1 AA
            assert page.locator("html").get_attribute("data-theme") == scheme


def test_the_theme_is_switched_and_remembered(page: Page) -> None:
    theme = page.get_by_role("button", name="Dark")
    assert theme.get_attribute("aria-pressed") == "false"
    theme.click()
    page.locator("html[data-theme=dark]").wait_for()
    page.reload()
    page.locator("html[data-theme=dark]").wait_for()
    assert page.get_by_role("button", name="Dark").get_attribute("aria-pressed") == "true"


def test_german_is_chosen_and_remembered_by_all_views(page: Page) -> None:
    page.get_by_label("Language").select_option("de")
    page.get_by_role("heading", name="Karten").wait_for()
    page.get_by_role("link", name="Statistik").click()
    page.get_by_role("heading", name="Störungen").wait_for()
    assert page.locator("html").get_attribute("lang") == "de"


def test_a_german_browser_is_answered_in_german(browser: Browser, site: Site) -> None:
    with tab(browser, site.url, locale="de-DE") as page:
        page.get_by_role("heading", name="Karten").wait_for()


class Visit(NamedTuple):
    """What a view showed of itself: of whom it asked something, and what it was like at each width of the screen."""

    asked: set[str]
    nameless: list[str]
    needed: dict[int, int]


@pytest.fixture(scope="module")
def visits(browser: Browser, steady: Site) -> dict[str, Visit]:
    """Every view, reached by its key."""
    found = {}
    asked: list[str] = []
    with (
        tab(browser, EMPTY) as page,
        told(page, "request", lambda request: asked.append(request.url)),
        told(page, "websocket", lambda socket: asked.append(socket.url)),
    ):
        page.goto(steady.address)
        for name in (*NAMES[1:], NAMES[0]):
            page.keyboard.press(f"Alt+{NAMES.index(name) + 1}")
            page.wait_for_url(f"**/{name}")
            page.get_by_text("Hub connected").wait_for()
            needed = {}
            for width in (480, 1280):
                page.set_viewport_size({"width": width, "height": 800})
                needed[width] = page.locator("html").evaluate("one => one.scrollWidth")
            netlocs = {urlsplit(url).netloc for url in asked}
            found[name] = Visit(netlocs, nameless_controls(page), needed)
            asked.clear()
    return found


def test_views_are_reached_by_keys_and_nothing_is_asked_of_other_machines(
    visits: dict[str, Visit], site: Site
) -> None:
    asked = {name: visit.asked for name, visit in visits.items()}
    assert asked == {name: {f"127.0.0.1:{site.port}"} for name in NAMES}


def test_the_content_is_one_tab_away(page: Page) -> None:
    page.keyboard.press("Tab")
    assert page.locator(":focus").inner_text() == "Skip to the content"


def test_every_control_has_a_name_for_screen_readers(visits: dict[str, Visit]) -> None:
    assert {name: visit.nameless for name, visit in visits.items()} == {name: [] for name in NAMES}


@pytest.mark.conforms("PG-01")
def test_without_the_token_one_sees_everything_and_can_change_nothing(browser: Browser, site: Site) -> None:
    with tab(browser, site.url) as page:
        page.get_by_text("You are viewing only.").wait_for()
        page.locator('tr[data-line="HW000001:0"]').wait_for()
        for button in page.locator("[data-writes]").all():
            assert button.is_disabled()


@pytest.mark.smoke
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.conforms("PG-01")
def test_readers_get_every_view(viewer: httpx.Client, name: str) -> None:
    answer = viewer.get(f"/{name}")
    assert answer.status_code == 200
    assert 'data-writer="no"' in answer.text


def test_nothing_is_wider_than_the_screen(visits: dict[str, Visit]) -> None:
    wider = {
        name: needs
        for name, visit in visits.items()
        if (needs := {width: needed for width, needed in visit.needed.items() if needed > width})
    }
    assert wider == {}


def test_an_answer_does_not_wait_until_the_one_before_is_acknowledged(
    steady: Site, asker: httpx.Client
) -> None:
    """Nagle's algorithm, which makes 40 ms of 3, is off."""
    asker.get("/link")
    sockets = [
        one.transport.get_extra_info("socket") for one in list(steady._server.server_state.connections)
    ]
    assert sockets
    assert all(one.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) for one in sockets)


def test_libraries_from_elsewhere_are_named_with_their_licences() -> None:
    vendor = HERE / "base" / "static" / "vendor"
    for name in ("htmx", "uPlot"):
        assert (vendor / f"{name}.LICENSE").read_text(encoding="utf-8").strip()
        assert [path.name for path in vendor.glob(f"{name}-*.js")] != []
    listed = (vendor / "README.md").read_text(encoding="utf-8")
    assert all(path.name in listed for path in vendor.iterdir() if path.name != "README.md")


def test_every_file_of_the_page_is_in_the_package() -> None:
    """pyproject's package-data: what it does not name is missing where canwire is installed."""
    root = Path(__file__).parents[2]
    table = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = table["tool"]["setuptools"]["package-data"]["canwire"]
    packed = {path for pattern in patterns for path in HERE.parent.glob(pattern)}
    files = {path for path in HERE.rglob("*") if path.is_file() and path.suffix not in (".py", ".pyc")}
    assert sorted(files - packed) == []


def test_nothing_can_be_pressed_before_its_script_is_there(page: Page) -> None:
    """A click that came too early would send a form as browsers do by themselves, and nothing would be done."""
    held: list[Route] = []
    page.route("**/forms.js", lambda route: held.append(route))
    with page.expect_request("**/forms.js"):
        page.goto(urljoin(page.url, "/send"), wait_until="commit")
    page.locator("main[inert]").wait_for()
    counts(page.locator("main[inert]"), 1)
    held[0].continue_()
    page.locator("main:not([inert])").wait_for()
