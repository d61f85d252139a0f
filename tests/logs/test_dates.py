"""Dates in the heads of logs, where the system knows no local time that long ago."""

from __future__ import annotations

import time
from collections.abc import Iterator
from datetime import datetime, timedelta, tzinfo

import pytest

from canwire.logs.dates import ns_of, ns_of_ole


class OnWindows(datetime):
    """Local times end before 1970 there, with this error."""

    def astimezone(self, tz: tzinfo | None = None) -> datetime:
        if self.tzinfo is None and self.year < 1970:
            raise OSError(22, "Invalid argument")
        return super().astimezone(tz)


@pytest.fixture
def _in_new_york(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    if not hasattr(time, "tzset"):
        pytest.skip("Windows has one zone for all programs")
    with monkeypatch.context() as patch:
        patch.setenv("TZ", "EST5")
        time.tzset()
        yield
    time.tzset()


@pytest.mark.usefixtures("_in_new_york")
def test_before_1970_windows_has_the_time_of_1970() -> None:
    assert ns_of(OnWindows(1969, 12, 31, 19, 0, 1)) == 1_000_000_000


def test_days_of_delphi_before_1970() -> None:
    days = (datetime(1965, 1, 2, 12) - datetime(1899, 12, 30)) / timedelta(days=1)
    assert ns_of_ole(days) < 0
