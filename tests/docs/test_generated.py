"""Pages that are written by scripts say what the scripts say now."""

from __future__ import annotations

import pytest

from canwire.boards.config.tables import options
from canwire.boards.kinds import KINDS


@pytest.mark.parametrize("name", ["configuration", "verbs"])
def test_a_page_is_up_to_date(name: str) -> None:
    module = __import__(name)
    assert module.PAGE.read_text(encoding="utf-8") == module.page(), f"run python docs/{name}.py"


def test_the_configuration_lists_every_kind_of_board() -> None:
    (listed,) = (option.help for option in options() if (option.table, option.name) == ("board", "kind"))
    assert [kind for kind in KINDS if f"{kind}," not in listed] == []
