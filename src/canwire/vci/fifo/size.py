"""The number of elements of a FIFO: its memory consists of whole pages, all of which it uses.

Source: VCI V4 manual chapter 4; rulings.md 12.
"""

from __future__ import annotations

PAGE = 4096
CONTROL = 24  # bytes of a FIFO's memory that its elements cannot use


def whole_pages(count: int, element_size: int) -> int:
    """The number of elements of `element_size` bytes that fit into the pages that `count` elements need.

    >>> whole_pages(32, 16)
    254
    """
    pages = -(-(count * element_size + CONTROL) // PAGE)
    return (pages * PAGE - CONTROL) // element_size
