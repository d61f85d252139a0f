"""A transmit list as a file: what was typed for each row, in JSON, so that it is checked as if it were typed anew."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire import BadValue
from canwire.web.fields import BadFields, Fields
from canwire.web.send.transmit_list import MOST_ROWS, Row

if TYPE_CHECKING:
    from collections.abc import Iterable

    from canwire.web.words import Words

MOST_BYTES = 1 << 20
_HEAD = "canwire transmit list"


def written(rows: Iterable[dict[str, str]]) -> str:
    """The file's text."""
    return json.dumps({"what": _HEAD, "rows": list(rows)}, indent=1)


def read(text: str, word: Words, typed: Callable[[Fields], Row]) -> list[Row]:
    """The rows, all checked; raises BadValue with the place of the first one that is wrong."""
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
