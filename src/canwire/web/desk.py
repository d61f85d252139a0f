"""The definition of a view, and the objects that all views share: the hub, the texts, the templates."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import jinja2
from markupsafe import Markup
from starlette.responses import HTMLResponse, Response

import canwire
from canwire.web.databases.loaded import Databases
from canwire.web.files import static_path
from canwire.web.words import HERE, LANGUAGES, Words, preferred, words_in

if TYPE_CHECKING:
    from collections.abc import Callable

    from starlette.requests import HTTPConnection, Request
    from starlette.routing import BaseRoute

    from canwire import Hub
    from canwire.web.link import HubLink

LANGUAGE_COOKIE = "canwire-language"


@dataclass(frozen=True)
class View:
    """One of the page's tabs: its path begins with /`name`, and its title is the text `name.title`.

    `scripts` and `styles` are files of its static folder (a name with a / is relative to `static_path`);
    `vendored` are scripts of base/static/vendor, loaded before them.
    """

    name: str
    routes: Callable[[Desk], list[BaseRoute]]
    scripts: tuple[str, ...] = ()
    styles: tuple[str, ...] = ()
    vendored: tuple[str, ...] = ()


@dataclass
class Desk:
    """The objects that the views of one server share. Hub time plus `epoch_ns(hub)` is wall-clock time.

    `databases` are the open network descriptions. A view adds to `closing` all that the server must close at its end,
    and stores in `kept`, under the view's name, objects that other views may use.
    """

    link: HubLink
    views: tuple[View, ...]
    epoch_ns: Callable[[Hub], int]
    databases: Databases
    closing: ExitStack = field(default_factory=ExitStack)
    kept: dict[str, Any] = field(default_factory=dict)

    def words(self, request: HTTPConnection) -> Words:
        """The texts in the language that this viewer has chosen or that the browser requests."""
        chosen = request.query_params.get("lang") or request.cookies.get(LANGUAGE_COOKIE)
        return words_in(preferred(chosen, request.headers.get("accept-language", "")))

    def page(self, request: Request, view: View, **values: Any) -> Response:
        """Render a view's page.jinja."""
        answer = self.part(request, f"{view.name}/page.jinja", view=view, **values)
        language = request.query_params.get("lang")
        if language in LANGUAGES:
            answer.set_cookie(LANGUAGE_COOKIE, language, samesite="lax", max_age=31_536_000)
        return answer

    def part(self, request: Request, template: str, **values: Any) -> Response:
        """Render a piece of a page; in templates `t` returns texts, and `writer` is true if this
        viewer has the token."""
        words = self.words(request)
        values |= {
            "t": words,
            "writer": bool(request.scope.get("writer")),
            "views": self.views,
            "hub_there": self.link.there,
            "languages": LANGUAGES,
            "version": canwire.__version__,
            "static": static_path(),
            "words_json": Markup(json.dumps(words.texts).replace("<", "\\u003c")),
        }
        return HTMLResponse(self._templates.get_template(template).render(values))

    @cached_property
    def _templates(self) -> jinja2.Environment:
        return jinja2.Environment(
            loader=jinja2.FileSystemLoader(HERE),
            autoescape=True,
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
        )
