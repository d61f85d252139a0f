"""Takes the pictures in docs/web/: each view of `canwire web`, light and dark, 1280 and 390 pixels wide.

python docs/web_pictures.py            needs canwire[web,databases], playwright, Pillow, and Debian's chromium
"""

from __future__ import annotations

import io
import os
import re
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

import canwire
from canwire import ChannelMode, Frame, WantedMode

PICTURES = Path(__file__).parent / "web"
WIDTHS = (1280, 390)
VIEWS = ("boards", "trace", "beside", "send", "panels", "cancheck", "statistics")
PARTS = (("value", "Speed"), ("slider", "Speed"), ("value", "Temperature"), ("switch", "Running"))
THEMES = ("light", "dark")
TALLEST = 2600
ENGINE = '#body .trace-row:not([hidden]):has(.c-id:text-is("100"))'
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
         "--disable-background-networking", "--disable-component-update", "--disable-sync"]  # fmt: skip
DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
 SG_ Temperature : 16|8@1- (1,40) [-40|215] "degC" ECU
 SG_ Running : 24|1@1+ (1,0) [0|1] "" ECU
BO_ 288 Gearbox: 2 ECU
 SG_ Gear : 0|4@1+ (1,0) [0|8] "" ECU
BO_ 512 Wheels: 8 ECU
 SG_ FrontLeft : 0|16@1+ (0.01,0) [0|300] "km/h" ECU
VAL_ 256 Running 1 "yes" 0 "no" ;
"""
ROWS = (
    {
        "message": "Wheels",
        "signal.FrontLeft": "50",
        "changes": "FrontLeft 20..120..20/0.5",
        "cycle": "20",
        "key": "e",
        "comment": "up and down",
    },
    {"id": "130", "data": "03 00", "cycle": "50", "exact": "on", "key": "g", "comment": "third gear"},
    {"format": "sequence", "steps": "7DF#02010C; 50; 7DF#02010D", "cycle": "500", "comment": "two requests"},
    {"id": "18DAF110", "extended": "on", "format": "remote", "dlc": "8", "comment": "remote frame"},
)


@contextmanager
def process(*words: str) -> Iterator[str]:
    """A canwire verb, and the line that it prints when it is ready."""
    command = [sys.executable, "-m", "canwire", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as started:
        assert started.stdout is not None
        try:
            yield started.stdout.readline()
        finally:
            started.terminate()


def traffic(hub: canwire.Hub, lines: list[canwire.LinePlace], ends: threading.Event) -> None:
    """A small car on can0."""
    with hub.open_channel(lines[0].board.id, lines[0].line) as channel:
        channel.set_up(ChannelMode(receive=8, transmit=64, frames=False))
        channel.activate()
        number = 0
        while not ends.wait(0.01):
            number += 1
            speed = 4000 + number * 7 % 2000
            channel.send(Frame(0x100, speed.to_bytes(2, "little") + bytes([50, 1, 0, 0, 0, number & 0xFF])))
            if number % 5 == 0:
                channel.send(Frame(0x120, bytes([number // 200 % 5 + 1, 0])))
            if number % 50 == 0:
                channel.send(Frame(0x18FF1234, bytes(range(8)), extended=True))


def arranged(page: Page, name: str) -> None:
    """Bring a view into the state that the picture is to show."""
    if name == "boards":
        page.locator("#registers .chip").first.wait_for()
    elif name == "trace":
        page.locator(ENGINE).first.wait_for()
        page.locator("#shown", has_text=re.compile(r"\d{3}")).wait_for()
        page.locator("#pause").click()
        page.locator(ENGINE).nth(3).click()
        page.locator(".wire svg").wait_for()
    elif name == "beside":
        page.locator("#mode-id").click()
        page.locator("#beside summary").click()
        page.locator("tr[data-row]").nth(len(ROWS) - 1).wait_for()
        if page.locator("#head .c-signals").count():  # not on a phone
            page.locator("#body .signal").first.dispatch_event("click")
            page.locator("#plot-keys", has_text=".").wait_for()
    elif name == "panels":
        for kind, signal in PARTS:
            page.locator("#add").click()
            page.locator("#part-form [name=kind]").select_option(kind)
            with page.expect_response(lambda answer: "message=Engine" in answer.url):
                page.locator("#part-form [name=message]").select_option("Engine")
            page.locator("#part-form [name=signal]").select_option(signal)
            page.locator("#keep-part").click()
        page.locator(".part .now", has_text="rpm").first.wait_for()
    elif name == "send":
        page.locator("tr[data-row]").nth(len(ROWS) - 1).wait_for()
    elif name == "cancheck":
        page.locator(".window [data-generators] tr[data-index]").dispatch_event("click")
        page.locator("[data-kind=send] [data-list] tr").nth(8).wait_for()
        page.locator("[data-kind=receive] [data-list] tr").nth(8).wait_for()
    elif name == "statistics":
        page.locator(".uplot").nth(3).wait_for()
        page.locator("#table td").first.wait_for()


def take(browser: Browser, url: str, address: str, name: str, theme: Any, width: int) -> None:
    with browser.new_context(viewport={"width": width, "height": 900}, color_scheme=theme) as context:
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.goto(address)
        page.goto(f"{url}{'trace' if name == 'beside' else name}")
        page.get_by_text("Hub connected").wait_for()
        arranged(page, name)
        tall = page.locator("html").evaluate("one => one.scrollHeight")
        tall = 1000 if name == "beside" and width > 760 else tall
        page.set_viewport_size(
            {"width": width, "height": min(TALLEST, max(900 if width > 760 else 600, tall))}
        )
        page.locator("footer").hover()
        shot = Image.open(io.BytesIO(page.screenshot()))
        small = shot.convert("RGB").quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        small.save(PICTURES / f"{name}-{theme}-{width}.png", optimize=True)


def main() -> None:
    PICTURES.mkdir(exist_ok=True)
    with ExitStack() as closing:
        home = closing.enter_context(tempfile.TemporaryDirectory())
        socket, database = os.path.join(home, "hub"), Path(home, "car.dbc")
        database.write_text(DBC)
        closing.enter_context(process("serve", "--socket", socket))
        hub = closing.enter_context(canwire.connect(socket, name="car"))
        lines = canwire.find_lines(hub, "can0", "CAN")
        for line in lines[:2] + lines[4:]:
            control = canwire.start_line(hub, line, WantedMode(500_000).mode(line.info.capabilities))
            closing.enter_context(control)
        ends = threading.Event()
        driving = threading.Thread(target=traffic, args=(hub, lines, ends))
        driving.start()
        closing.callback(driving.join)
        closing.callback(ends.set)
        printed = closing.enter_context(process("web", "--hub", socket, "--db", str(database)))
        address = printed.split()[-1]
        url = address.partition("?")[0]
        started = closing.enter_context(sync_playwright())
        browser = started.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        closing.callback(browser.close)
        fill_list(browser, url, address)
        start_cancheck(browser, url, address)
        for name in sys.argv[1:] or VIEWS:
            for theme in THEMES:
                for width in WIDTHS:
                    take(browser, url, address, name, theme, width)


def fill_list(browser: Browser, url: str, address: str) -> None:
    """Rows of the transmit list, the first one in its cycle; and a minute of statistics begins."""
    with browser.new_context() as context:
        page = context.new_page()
        page.set_default_timeout(60_000)
        page.goto(address)
        for row in ROWS:
            form = {"line": "HW000001:0", "format": "classic", **row}
            assert context.request.post(f"{url}send/put", form=form).ok
        for number in ("1", "2", "3"):
            context.request.post(f"{url}send/start", form={"number": number})
        page.goto(f"{url}trace")
        page.locator("#shown", has_text=re.compile(r"\d{3}")).wait_for()


def start_cancheck(browser: Browser, url: str, address: str) -> None:
    """A pair of windows, and the range generator of the manual's first example."""
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(address)
        bytes_ = {"b0": "00", "t0": "11", "b1": "11", "t1": "22", "b2": "33", "t2": "00"}
        identifiers = {"id": "025E0235", "idto": "025E0235", "dlc": "3", "ext": "on", "delay": "150"}
        ranging = {"range": "on", "wrap": "on", "repeat": "on", "state": "active"}
        for name, form in (
            ("start", {"port": "CID1:"}),
            ("open", {"kind": "both"}),
            ("filter", {"number": "100", "code": "0", "mask": "FFFFFFFF"}),
            ("generator", {"number": "100", **bytes_, **identifiers, **ranging}),
        ):
            assert context.request.post(f"{url}cancheck/{name}", form=form).ok, name


if __name__ == "__main__":
    main()
