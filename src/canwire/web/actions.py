"""Requests that change something: a POST with fields, answered in JSON that base/static/forms.js shows."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl

from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response

from canwire import CanwireError, HubLost
from canwire.web.fields import BadFields, Fields

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.desk import Desk
    from canwire.web.words import Words

MOST_FIELDS = 400


@dataclass(frozen=True)
class Call:
    """One request to change something: its viewer, the language, and the typed values."""

    desk: Desk
    request: Request
    word: Words
    fields: Fields


Do = Callable[[Call], "str | Response"]


def action(desk: Desk, do: Do) -> Callable[[Request], Awaitable[Response]]:
    """Return an endpoint that runs `do` in a thread; the page shows the result as its status.

    BadFields are shown at their fields (422); other errors of canwire are shown unchanged (409, 503 for a lost hub).
    """

    async def endpoint(request: Request) -> Response:
        word = desk.words(request)
        try:
            pairs = parse_qsl(
                (await request.body()).decode(), keep_blank_values=True, max_num_fields=MOST_FIELDS
            )
        except ValueError as error:
            return _answer(400, str(error))
        fields = Fields(dict(pairs), word)
        try:
            done = await run_in_threadpool(do, Call(desk, request, word, fields))
        except BadFields as bad:
            return _answer(422, word("base.see-fields"), bad.faults)
        except HubLost as error:
            return _answer(503, word.error(error))
        except (CanwireError, OSError) as error:
            return _answer(409, word.error(error))
        return done if isinstance(done, Response) else _answer(200, done)

    return endpoint


def _answer(status: int, message: str, faults: dict[str, str] | None = None) -> Response:
    return JSONResponse({"message": message, "faults": faults or {}}, status)
