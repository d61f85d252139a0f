"""`canwire web` on Windows, asked from Linux."""

from __future__ import annotations

import re
import urllib.request
from http.cookiejar import CookieJar

from tests.windows.conftest import LONG_S


def test_the_page_is_served(page: str) -> None:
    opener = urllib.request.build_opener(
        urllib.request.ProxyHandler({}), urllib.request.HTTPCookieProcessor(CookieJar())
    )
    with opener.open(page, timeout=LONG_S) as first:  # whose cookie lets the next ones in
        text = first.read().decode("utf-8")
    assert "canwire 0." in text
    base = page.partition("/?")[0]
    found = sorted(set(re.findall(r'(?:href|src)="(/[^"#?]*)', text)))
    assert any(each.endswith(".js") for each in found), found
    for each in found:
        with opener.open(base + each, timeout=LONG_S) as part:
            kind = part.headers["Content-Type"]
            assert part.status == 200
            assert ("javascript" in kind) is each.endswith(".js"), (each, kind)
