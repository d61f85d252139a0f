"""What a router refuses before it listens."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import pytest

from canwire import BadConfig, BadValue, Event, route
from tests.cases import each


@each(
    ("listen", "error"),
    [
        ([], BadValue),
        ("tcp/127.0.0.1:7447", BadValue),
        (["tcp/127.0.0.1:7447"], BadConfig),
    ],  # the last: no such file
)
def test_endpoints_are_a_list_with_one_at_least(
    tmp_path: Path, listen: list[str], error: type[Exception]
) -> None:
    with closing(Event()) as stop, pytest.raises(error):
        route(listen, str(tmp_path / "none.toml"), stop=stop)
