"""What the hub is told to filter is what python-can's filters mean."""

from __future__ import annotations

from typing import Any

import can
from hypothesis import given
from hypothesis import strategies as st

from canwire import FilterContent, FilterMode
from canwire.boards.can.message_filter import MessageFilter, message_filter
from canwire.python_can.bus import CanwireBus
from canwire.python_can.filters import LIST_SIZE, OPEN, planned
from tests.effort import examples

ids = st.integers(0, 0x1FFFFFFF) | st.integers(0, 0x7FF)
masks = ids | st.sampled_from([0, 0x7FF, 0x1FFFFFFF, 0x700, 0x1FFF0000])
one_filter = st.fixed_dictionaries({"can_id": ids, "can_mask": masks}, optional={"extended": st.booleans()})


class Hubs:
    """As a HubChannel, but with the filter itself."""

    def __init__(self) -> None:
        self.filter: MessageFilter = message_filter(FilterMode.PASS, 2048, FilterMode.PASS, LIST_SIZE)

    def replace_filters(self, standard: FilterContent, extended: FilterContent) -> None:
        for content, of in ((standard, self.filter.standard), (extended, self.filter.extended)):
            of.mode = content.mode
            of.set_pattern(*content.pattern)
            for code, mask in content.listed:
                of.add(code, mask)


class Only(can.BusABC):
    """python-can's own opinion."""

    def __init__(self, filters: Any) -> None:
        self._filters = filters or None

    def send(self, msg: can.Message, timeout: float | None = None) -> None: ...


@examples(100)
@given(st.lists(one_filter, max_size=6), st.lists(st.tuples(ids, st.booleans()), max_size=20), st.data())
def test_the_hub_passes_what_python_can_passes(filters: Any, tried: Any, data: st.DataObject) -> None:
    plan, hub = planned(filters), Hubs()
    plan.apply(hub)  # type: ignore[arg-type]
    near = [(one["can_id"], extended) for one in filters for extended in (False, True)]
    for id, extended in tried + near:
        id = id if extended else id & 0x7FF
        for remote in (False, True):
            message = can.Message(arbitration_id=id, is_extended_id=extended, is_remote_frame=remote)
            wanted = Only(filters)._matches_filters(message)
            passed = hub.filter.judge(id | (extended << 23 | remote << 22) << 32) != 0
            assert passed == wanted if plan.exact else passed or not wanted


def test_identifier_lists_fit_and_many_wide_patterns_do_not() -> None:
    assert planned(None) is OPEN
    assert planned([]) is OPEN
    listed = [{"can_id": k, "can_mask": 0x7FF, "extended": False} for k in range(0, 600, 3)]
    assert planned(listed).exact
    assert planned(listed).extended.mode is FilterMode.LOCK
    wide = [{"can_id": k << 24, "can_mask": 0x1F000000, "extended": True} for k in range(4)]
    assert not planned(wide).exact


def test_the_class_is_what_the_entry_point_names() -> None:
    from canwire import python_can

    assert python_can.CanwireBus is CanwireBus
