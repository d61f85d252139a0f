"""A transmit list as a file: the typed values of each row, in JSON. Loading checks them as if they were typed."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadValue, LinFrame
from canwire.web.fields import BadFields, Fields
from canwire.web.send.transmit_list import MOST_ROWS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from canwire.web.send.row import Row, Sent
    from canwire.web.words import Words

MOST_BYTES = 1 << 20
_HEAD = "canwire transmit list"


def written(rows: Iterable[dict[str, str]]) -> str:
    """The file's text."""
    return json.dumps({"what": _HEAD, "rows": list(rows)}, indent=1)


def read(text: str, word: Words, typed: Callable[[Fields], Row]) -> list[Row]:
    """Return the rows, all checked; raises BadValue with the place of the first invalid row."""
    try:
        told = json.loads(text)
        rows = told["rows"]
        if told["what"] != _HEAD or not isinstance(rows, list) or len(rows) > MOST_ROWS:
            raise ValueError
    except (ValueError, TypeError, KeyError, RecursionError):
        raise BadValue(word("send.no-list")) from None
    found = []
    for place, row in enumerate(rows, 1):
        if not isinstance(row, dict) or not all(isinstance(one, str) for one in row.values()):
            raise BadValue(word("send.bad-row", row=place, fault=""))
        try:
            found.append(typed(Fields({**row, "number": ""}, word)))
        except BadFields as bad:
            raise BadValue(word("send.bad-row", row=place, fault=str(bad))) from None
    return found


def typed_of(row: Row) -> dict[str, str]:
    """Return the typed values that result in this row."""
    content = row.content
    return {
        "line": row.line,
        **_frame_of(content.frame),
        **({"format": "linsequence" if content.lin else "sequence"} if content.steps else {}),
        "cycle": f"{row.cycle_ms:g}" if row.cycle_ms else "",
        "most": str(row.most or ""),
        "key": row.key,
        "comment": row.comment,
        "exact": "on" if row.exact else "",
        "message": content.message,
        "steps": content.text,
        "changes": ", ".join(map(str, content.changes)),
        **{f"signal.{name}": value for name, value in content.signals.items()},
    }


def _frame_of(frame: Sent) -> dict[str, str]:
    if isinstance(frame, LinFrame):
        return {
            "format": "header" if frame.header_only else "lin",
            "id": f"{frame.id:02X}",
            "extended": "",
            "data": frame.data.hex(" ").upper(),
            "dlc": str(frame.length) if frame.header_only else "",
            "checksum": "" if frame.enhanced or frame.header_only or frame.id >= 0x3C else "on",
        }
    return {
        "format": "remote"
        if frame.remote
        else "fdbrs"
        if frame.bit_rate_switch
        else "fd"
        if frame.fd
        else "classic",
        "id": f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}",
        "extended": "on" if frame.extended else "",
        "data": frame.data.hex(" ").upper(),
        "dlc": str(frame.dlc),
    }
