"""No view has a fault that axe-core finds, in light and dark.

axe-core (MPL-2.0) is fetched from npm's registry by tests/others/packages.py; without it these tests are skipped.
"""

from __future__ import annotations

import os
import tarfile
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import Frame
from canwire.web.views import VIEWS
from tests.cases import each
from tests.hubs import LONG_S
from tests.others.packages import AXE
from tests.web.conftest import served_site, tab
from tests.web.trace.watching import rows_with, sender

pytest.importorskip("cantools")
if TYPE_CHECKING:
    from collections.abc import Iterator

    from playwright.sync_api import Browser, Page

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-13")

RUN = "axe.run().then(found => found.violations.map(one => [one.id, one.nodes.map(node => node.html)]))"
DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
"""


@pytest.fixture(scope="session")
def axe() -> str:
    """The script; tests are skipped where CANWIRE_OTHERS names no folder with it."""
    packages = sorted(Path(os.environ.get("CANWIRE_OTHERS", "/nowhere")).glob(AXE))
    if not packages:
        pytest.skip(f"CANWIRE_OTHERS names no folder with {AXE}: see tests/others/packages.py")
    with tarfile.open(packages[-1]) as packed:
        script = packed.extractfile("package/axe.min.js")
        assert script is not None
        return script.read().decode()


@pytest.fixture(scope="module")
def described(steady: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """A page of its own on the hub that all share, with a database and two rows to send."""
    path: Path = tmp_path_factory.mktemp("dbc") / "car.dbc"
    path.write_text(DBC)
    with served_site(steady.link.hub.address, [str(path)]) as site:
        yield site


def faults(page: Page, axe: str) -> object:
    page.evaluate(axe)
    return page.evaluate(RUN)


@pytest.mark.finding("page 16")
@each("name", [view.name for view in VIEWS])
def test_views_have_none_in_light_and_dark(browser: Browser, described: Site, axe: str, name: str) -> None:
    with tab(browser, described.address) as page:
        row = {"line": "HW000001:0", "message": "Engine", "signal.Speed": "5", "cycle": "20"}
        assert page.request.post(f"{described.url}send/put", form=row).ok
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.goto(f"{described.url}{name}")
            page.get_by_text("Hub connected").wait_for()
            page.locator("main:not([inert])").wait_for()
            assert faults(page, axe) == [], scheme


@pytest.mark.finding("page 16")
def test_the_trace_has_none_with_rows_opened_and_plotted_nor_its_dialogs(
    browser: Browser, described: Site, axe: str
) -> None:
    with (
        canwire.connect(described.link.hub.address, name="axe") as hub,
        sender(hub) as channel,
        tab(browser, described.address) as page,
    ):
        page.goto(f"{described.url}trace")
        page.locator("#beside summary").click()
        page.locator("body[data-listening=yes]").wait_for()
        channel.send(Frame(0x100, bytes(8)), timeout=LONG_S)
        rows_with(page, id="100").first.click()
        page.locator(".wire svg").wait_for()
        assert faults(page, axe) == []
        page.locator("#mode-id").click()
        page.locator("#body .signal").first.click()
        page.locator("#plot canvas").wait_for()
        assert faults(page, axe) == []
        for name in ("saving", "colours", "databases", "replaying", "row-dialog", "lin-dialog"):
            page.locator(f"#{name}").evaluate("one => one.showModal()")
            assert faults(page, axe) == [], name
            page.locator(f"#{name}").evaluate("one => one.close()")
