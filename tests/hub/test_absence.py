"""How long a hub is away, by whatever clock."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import Absence


def test_a_clock_that_is_no_function_is_refused_when_it_is_given() -> None:
    wrong: Any = 12.5
    with pytest.raises(TypeError, match=r"^clock_s 12\.5: must be a function, such as time\.monotonic$"):
        Absence(wrong)
