"""How many elements a FIFO really gets: its memory comes in pages, and none of a page is wasted.

Source: VCI V4 manual chapter 4; rulings.md 12.
"""

from __future__ import annotations

PAGE = 4096
CONTROL = 24  # bytes of a FIFO's memory that its elements do not get


def whole_pages(count: int, element_size: int) -> int:
    """The elements of so many bytes that fit into the pages which `count` of them take.

    >>> whole_pages(32, 16)
    254
    """
    pages = -(-(count * element_size + CONTROL) // PAGE)
    return (pages * PAGE - CONTROL) // element_size
