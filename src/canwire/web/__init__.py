"""The page: what happens on a hub's boards, in a browser. A program of its own and a client of the hub, as others are.

How a view is added. A view is a folder here, `web/NAME/`, and a row in `views.py`:

    web/NAME/view.py         VIEW = View("NAME", routes, ...): routes(desk) gives the Starlette routes below /NAME
    web/NAME/page.jinja      extends "base/page.jinja"; its content stands in `{% block main %}`
    web/NAME/words/en.toml   everything that people read: t("NAME.key") in templates, word("NAME.key") in scripts
    web/NAME/words/de.toml   the same keys in German (tests/web/test_words.py tells what is missing)
    web/NAME/static/...      scripts and styles, served as /static/NAME/...; View's `scripts` and `styles` name them

`web/boards/` is the model. What a view's code has at hand:

- `desk.page(request, VIEW, ...)` renders a page, `desk.part(request, "NAME/part.jinja", ...)` a piece of one.
- `desk.link.hub` is the connection to the hub; it raises HubLost while that is away. Calls block, so they stand in
  plain functions (`def`), which Starlette runs in threads, never in coroutines. `desk.link.subscribe(began, ended)`
  tells whoever holds something at the hub when it is there and when it is gone; the page's head shows both.
- What changes something is a POST: `Route("/NAME/do", action(desk, do), methods=["POST"])` with `do(call: Call)`
  (actions.py). `call.fields` checks what was typed (fields.py): every fault goes to its field in one answer, and
  nothing is done. What `do` returns is shown in the page's status line, and so is an error of the hub.
- Forms with `data-action="/NAME/do"` and buttons with `data-post="/NAME/do"` (their `data-name="value"`s are the
  fields) are sent by base/static/forms.js; `data-writes` disables them for viewers without the token. After a success
  the event "changed" goes to document.body.
- A part that the server draws anew now and then: htmx, `hx-get="/NAME/part" hx-trigger="every 1s, changed from:body"`.
- What comes often goes through a web socket: live.py's `converse`. Keep no queue for a viewer: answer what it asks for
  (trace/feed.py).
- Choices that are remembered: `data-remember="NAME.key"` on a field, or `remembered(key, fallback)` of base.js.
- gate.py has refused strangers before a view is asked: foreign hosts and origins, wrong tokens, bodies over 64 KiB,
  and everybody without the token, where viewers are let in everything but their GETs. `request.scope["writer"]` tells a
  web socket's view the same.

Tests: `tests/web/` has the fixtures `site` (a server on a hub of its own), `client` (with the token), `viewer`
(without) and `page` (a Chromium tab). Nothing there waits by the clock: elements are waited for.
"""
