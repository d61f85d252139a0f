"""The page's views, in the order of its tabs."""

from __future__ import annotations

from canwire.web.boards.view import VIEW as BOARDS
from canwire.web.cancheck.view import VIEW as CANCHECK
from canwire.web.panels.view import VIEW as PANELS
from canwire.web.send.view import VIEW as SEND
from canwire.web.statistics.view import VIEW as STATISTICS
from canwire.web.trace.view import VIEW as TRACE

VIEWS = (BOARDS, TRACE, SEND, PANELS, CANCHECK, STATISTICS)
