"""Dates in the heads of logs: most formats contain the local time of the recording machine."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

_MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")
_DAYS = ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun")
_OLE_ZERO = datetime(1899, 12, 30)
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)


def ns_of(moment: datetime) -> int:
    """Return nanoseconds since 1970. A moment without a zone is local time, by the offset of January 1970 if needed."""
    try:
        since = moment.astimezone(UTC) - _EPOCH
    except OSError:  # Windows: local time begins in 1970 and ends in 3000
        since = moment.replace(tzinfo=datetime(1970, 1, 3).astimezone().tzinfo) - _EPOCH
    return since // _MICROSECOND * 1000


def local(time_ns: int) -> datetime:
    """Return the local time, to the microsecond."""
    return (_EPOCH + timedelta(microseconds=time_ns // 1000)).astimezone()


def ole_days(time_ns: int) -> float:
    """Days since the end of 1899, local time, as in Delphi and Windows programs."""
    return (local(time_ns).replace(tzinfo=None) - _OLE_ZERO) / timedelta(days=1)


def ns_of_ole(days: float) -> int:
    """Return nanoseconds since 1970, from local days since the end of 1899; raises OverflowError, ValueError."""
    return ns_of(_OLE_ZERO + timedelta(days=days))


def vector_date(time_ns: int) -> str:
    """`Wed Sep 30 03:06:13.191 pm 2026`: English names whatever the locale."""
    moment = local(time_ns)
    half = "pm" if moment.hour >= 12 else "am"
    return (
        f"{_DAYS[moment.weekday()]} {_MONTHS[moment.month - 1]} {moment.day:02d} "
        f"{(moment.hour + 11) % 12 + 1:02d}:{moment:%M:%S}.{moment.microsecond // 1000:03d} {half} {moment.year}"
    )


def ns_of_vector_date(text: str) -> int | None:
    """The time of a date such as `[Wed] Sep 30 03:06:13[.191] [pm] 2026`; also German names; None for other text."""
    words = text.replace(",", " ").split()
    months = [word for word in words if word[:3].title().replace("Mär", "Mar") in _MONTH_OF]
    clock = next((word for word in words if word.count(":") == 2), "")
    numbers = [int(word) for word in words if word.isdigit()]
    if not months or not clock or len(numbers) < 2:
        return None
    hour, minute, second = clock.split(":")
    afternoon = [word.lower() for word in words if word.lower() in ("am", "pm")]
    hours = int(hour) % 12 + 12 * (afternoon[0] == "pm") if afternoon else int(hour)
    whole, _, rest = second.partition(".")
    month = _MONTH_OF[months[0][:3].title().replace("Mär", "Mar")]
    try:
        moment = datetime(
            numbers[-1], month, numbers[0], hours, int(minute), int(whole), int((rest + "000000")[:6])
        )
        return ns_of(moment)
    except (ValueError, OverflowError):
        return None


_MONTH_OF = {name: number for number, name in enumerate(_MONTHS, 1)} | {"Mai": 5, "Okt": 10, "Dez": 12}
