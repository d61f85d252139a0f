"""The page: shows the activity on a hub's boards in a browser. The server is a separate process and a client of the
hub.

How to add a view: a view is a folder here, `web/NAME/`, and a row in `views.py`:

    web/NAME/view.py         VIEW = View("NAME", routes, ...): routes(desk) gives the Starlette routes below /NAME
    web/NAME/page.jinja      extends "base/page.jinja"; its content is in `{% block main %}`
    web/NAME/words/en.toml   every text of the view: t("NAME.key") in templates, word("NAME.key") in scripts
    web/NAME/words/de.toml   the same keys in German (tests/web/test_words.py reports missing ones)
    web/NAME/static/...      scripts and styles; View's `scripts` and `styles` name them, and they import each other by
                             relative paths, since their address (files.py) changes with what is in them

`web/boards/` is the model. The code of a view can use:

- `desk.page(request, VIEW, ...)` renders a page, `desk.part(request, "NAME/part.jinja", ...)` a piece of one.
- `desk.link.hub` is the connection to the hub; it raises HubLost while the hub is away. Calls block, so they belong in
  plain functions (`def`), which Starlette runs in threads, never in coroutines. `desk.link.subscribe(began, ended)`
  calls back when the hub is connected and when it is lost; the head of the page shows both.
- A request that changes something is a POST: `Route("/NAME/do", action(desk, do), methods=["POST"])` with
  `do(call: Call)` (actions.py). `call.fields` checks the typed values (fields.py): one answer shows every fault at
  its field, and nothing is changed. The status line of the page shows the text that `do` returns, or the hub's error.
- Forms with `data-action="/NAME/do"` and buttons with `data-post="/NAME/do"` (their `data-name="value"`s are the
  fields) are sent by base/static/forms.js; `data-writes` disables them for viewers without the token. After a success
  the event "changed" is dispatched to document.body.
- A part that the server renders repeatedly: htmx, `hx-get="/NAME/part" hx-trigger="every 1s, changed from:body"`.
  While one of its elements is pressed it stays as it is (base/static/press.js).
- Frequent data use a web socket: `converse` in live.py. Keep no queue for a viewer; answer its requests
  (trace/feed.py).
- Choices that are remembered: `data-remember="NAME.key"` on a field, or `remembered(key, fallback)` of base.js.
- gate.py refuses requests before a view gets them: foreign hosts and origins, wrong tokens, bodies over 64 KiB, and
  requests without the token (with `viewers`, their GETs are allowed). `request.scope["writer"]` is True if a web
  socket may change something.

Tests: `tests/web/` has the fixtures `site` (a server on a separate hub), `client` (with the token), `viewer`
(without) and `page` (a Chromium tab). Tests wait for elements, never for a fixed time.
"""
