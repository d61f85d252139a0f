"""Scripts and styles at addresses that change with what is in them: a browser keeps them without asking again."""

from __future__ import annotations

import hashlib
from functools import cache
from typing import Any

from starlette.responses import Response
from starlette.routing import Mount
from starlette.staticfiles import StaticFiles

from canwire.web.words import HERE

_FOR_GOOD = "max-age=31536000, immutable"  # a year


@cache
def static_path() -> str:
    """Where the files of web/NAME/static are served, as NAME/...: /static/ and a digest of all of them."""
    digest = hashlib.sha256()
    for path in sorted(HERE.glob("*/static/**/*")):
        if path.is_file():
            digest.update(f"{path.relative_to(HERE).as_posix()}\0{path.stat().st_size}\0".encode())
            digest.update(path.read_bytes())
    return f"/static/{digest.hexdigest()[:16]}"


def static_routes() -> list[Mount]:
    """Make the routes of these files, one for each package."""
    folders = sorted(HERE.glob("*/static"))
    return [Mount(f"{static_path()}/{path.parent.name}", _Files(directory=path)) for path in folders]


class _Files(StaticFiles):
    def file_response(self, *given: Any, **named: Any) -> Response:
        answer = super().file_response(*given, **named)
        answer.headers["cache-control"] = _FOR_GOOD
        return answer
