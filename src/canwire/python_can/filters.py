"""Converts python-can's filters to the hub's: one pattern and one list of identifiers for each frame format.

If they do not fit, the hub gets one pattern that lets through all wanted frames and others, and this process filters
the others out (`exact` is False then). Source: python-can 4.6 bus.py, set_filters; boards/can/message_filter.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from can.typechecking import CanFilters

from canwire import FilterContent, FilterMode, HubChannel

LIST_SIZE = 2048  # identifiers of the hub's list
_ENTRIES = 2 * LIST_SIZE  # each as data and as remote frame
_STANDARD_BITS, _EXTENDED_BITS = 11, 29

Pattern = tuple[int, int]


class Plan(NamedTuple):
    """The hub's filters for 11-bit and for 29-bit frames; `exact` if only wanted frames pass."""

    standard: FilterContent
    extended: FilterContent
    exact: bool

    def apply(self, channel: HubChannel) -> None:
        """Set the filters in one step, so that no frame is lost that passes both the old and the new ones."""
        channel.replace_filters(self.standard, self.extended)


def planned(filters: CanFilters | None) -> Plan:
    """The plan for these filters; with None or an empty list, everything passes."""
    if not filters:
        return OPEN
    plans = [_plan(filters, extended) for extended in (False, True)]
    return Plan(plans[0][0], plans[1][0], plans[0][1] and plans[1][1])


def _plan(filters: CanFilters, extended: bool) -> tuple[FilterContent, bool]:
    patterns = sorted(set(_patterns(filters, extended)), key=lambda pattern: pattern[1].bit_count())
    if not patterns:
        return FilterContent(FilterMode.LOCK), True
    widest, rest = patterns[0], tuple(patterns[1:])
    if widest[1] == 0:
        return FilterContent(FilterMode.PASS), True
    bits = (_EXTENDED_BITS if extended else _STANDARD_BITS) + 1
    if sum(1 << bits - mask.bit_count() for _, mask in rest) <= _ENTRIES:
        return FilterContent(FilterMode.INCLUSIVE, widest, rest), True
    return FilterContent(FilterMode.INCLUSIVE, _wide_enough(patterns)), False


def _patterns(filters: CanFilters, extended: bool) -> list[Pattern]:
    """The filters for this format in the hub's form: with the remote bit at the end, which is not compared."""
    limit = (1 << (_EXTENDED_BITS if extended else _STANDARD_BITS)) - 1
    found = []
    for one in filters:
        wanted = one.get("extended")
        if wanted is not None and bool(wanted) != extended:
            continue
        mask = one["can_mask"]
        code = one["can_id"] & mask
        if code <= limit:  # else it asks for a bit that no such identifier has
            found.append((code << 1, (mask & limit) << 1))
    return found


def _wide_enough(patterns: Sequence[Pattern]) -> Pattern:
    code, mask = patterns[0]
    for other_code, other_mask in patterns[1:]:
        mask &= other_mask & ~(code ^ other_code)
    return code & mask, mask


OPEN = Plan(FilterContent(FilterMode.PASS), FilterContent(FilterMode.PASS), True)
