"""`canwire web` on Windows, asked from Linux."""

from __future__ import annotations

import re
import urllib.request
from http.cookiejar import CookieJar

from tests.windows.conftest import LONG_S, Windows, line_of


def test_the_page_is_served(windows: Windows, hub: str) -> None:
    address = served(windows, hub)
    opener = urllib.request.build_opener(
        urllib.request.ProxyHandler({}), urllib.request.HTTPCookieProcessor(CookieJar())
    )
    with opener.open(address, timeout=LONG_S) as page:  # whose cookie lets the next ones in
        text = page.read().decode("utf-8")
    assert "canwire 0." in text
    base = address.partition("/?")[0]
    found = sorted(set(re.findall(r'(?:href|src)="(/[^"#?]*)', text)))
    assert any(each.endswith(".js") for each in found), found
    for each in found:
        with opener.open(base + each, timeout=LONG_S) as part:
            kind = part.headers["Content-Type"]
            assert part.status == 200
            assert ("javascript" in kind) is each.endswith(".js"), (each, kind)


def served(windows: Windows, hub: str) -> str:
    """The address of a page on this hub, with the token."""
    web = windows.start("-m", "canwire", "web", "--port", "0", "--hub", hub)
    found = re.search(r"http://\S+", line_of(web, "canwire web:"))
    assert found is not None
    return found[0]
