"""VCI's two-stage message filter: a bit pattern, then a list of identifiers, separate for 11-bit and 29-bit frames.

It compares id << 1 | remote. The result for a frame is VCI's acceptance code: 0 rejected, 1 by the
pattern, 2 by the list, 3 passed an excluding filter, 255 not filtered at all.
Source: VCI V4 manual 5.2.4 and 7.3.14; reference/vci.md section 3 (CAN_ACCEPT_).
"""

from __future__ import annotations

from array import array

from canwire import _mem
from canwire.errors import BadFilter, NotInitialised

REJECTED, BY_PATTERN, BY_LIST, NOT_EXCLUDED, ALWAYS = 0, 1, 2, 3, 255
_BY_PATTERN, _BY_LIST, _NOT_EXCLUDED, _ALWAYS = BY_PATTERN, BY_LIST, NOT_EXCLUDED, ALWAYS
_LOCK, _PASS, _INCLUSIVE, _EXCLUSIVE = 1, 2, 3, 4
_NEVER = 1 << 31  # a pattern's bit that no frame has: CAN_ACC_CODE_NONE
_REMOTE = 1 << 22
_EXTENDED = 1 << 23
_STANDARD_BITS, _EXTENDED_BITS = 12, 30
LARGEST_LIST = 1 << 16  # identifiers; no client may fill the memory of its hub


class FormatFilter:
    """The filter for one frame format; its list holds `size` identifiers, each as data and as remote frame.

    A new filter accepts every frame in every mode but LOCK: an inclusive one has an open pattern, an
    excluding one a shut pattern.
    """

    def __init__(self, mode: int, size: int, width: int) -> None:
        self.mode = mode
        self.size = size
        self.width = width
        self.listed: set[int] = set()
        self._block = array("Q", [0] * 64)
        self._bits = _mem.words_of(self._block)
        self.code = 0 if mode != _EXCLUSIVE else _NEVER
        self.mask = 0 if mode != _EXCLUSIVE else _NEVER

    def judge(self, value: int) -> int:
        """The acceptance code of a frame; `value` is its id << 1 | remote."""
        if self.mode == _PASS:
            return _ALWAYS
        if self.mode == _LOCK:
            return 0
        matched = 0
        if (value ^ self.code) & self.mask == 0:
            matched = _BY_PATTERN
        elif self._is_listed(value):
            matched = _BY_LIST
        if self.mode == _INCLUSIVE:
            return matched
        return 0 if matched else _NOT_EXCLUDED

    def set_pattern(self, code: int, mask: int) -> None:
        """Set the pattern. Bits above the identifier are ignored, except bit 31: compared, it shuts the pattern."""
        self.code, self.mask = self._significant(code, mask)

    def add(self, code: int, mask: int) -> None:
        """Add all values that match the pattern to the list; raises BadFilter if they do not fit."""
        code, mask = self._significant(code, mask)
        if self.size == 0:
            raise NotInitialised("this filter was set up without a list of identifiers")
        if mask & _NEVER and code & _NEVER:
            return
        free = [1 << bit for bit in range(self.width) if not mask >> bit & 1]
        if 1 << len(free) > 2 * self.size:
            raise BadFilter(
                f"pattern {code:#x}/{mask:#x} has {1 << len(free)} entries: the list holds {2 * self.size}"
            )
        spread = [code & mask]
        for bit in free:
            spread += [value | bit for value in spread]
        listed = self.listed.union(spread)
        if len(listed) > 2 * self.size:
            raise BadFilter(f"{len(listed)} entries: the list holds {2 * self.size}")
        self._take(listed)

    def remove(self, code: int, mask: int) -> None:
        """Remove all values that match the pattern from the list."""
        code, mask = self._significant(code, mask)
        self._take({value for value in self.listed if (value ^ code) & mask})

    def _significant(self, code: int, mask: int) -> tuple[int, int]:
        significant = (1 << self.width) - 1 | _NEVER
        for name, value in (("code", code), ("mask", mask)):
            if not 0 <= value < 1 << 32:
                raise BadFilter(f"{name} {value:#x}: a whole number of 32 bits")
        return code & significant, mask & significant

    def _take(self, listed: set[int]) -> None:
        self.listed = listed
        if self.width == _STANDARD_BITS:
            words = [0] * 64
            for value in listed:
                words[value >> 6] |= 1 << (value & 63)
            for k in range(64):
                self._bits[k] = words[k]

    def _is_listed(self, value: int) -> bool:
        if self.width == _STANDARD_BITS:
            return self._bits[value >> 6] >> (value & 63) & 1 != 0
        return value in self.listed


class MessageFilter:
    """The filters of both frame formats."""

    def __init__(self, standard: FormatFilter, extended: FormatFilter) -> None:
        self.standard = standard
        self.extended = extended

    def judge(self, head: int) -> int:
        """The acceptance code of a frame with this id/info word."""
        info = head >> 32
        value = (head & 0x1FFFFFFF) << 1
        if info & _REMOTE:
            value |= 1
        return self.extended.judge(value) if info & _EXTENDED else self.standard.judge(value)

    def of(self, extended: bool) -> FormatFilter:
        return self.extended if extended else self.standard


def message_filter(
    standard_mode: int, standard_size: int, extended_mode: int, extended_size: int
) -> MessageFilter:
    """A filter through which all frames pass, except in mode 1, lock; sizes are those of the lists.

    Raises BadFilter.
    """
    for mode in (standard_mode, extended_mode):
        if mode not in (_LOCK, _PASS, _INCLUSIVE, _EXCLUSIVE):
            raise BadFilter(f"filter mode {mode}: 1 lock, 2 pass, 3 inclusive, 4 exclusive")
    for size in (standard_size, extended_size):
        if not 0 <= size <= LARGEST_LIST:
            raise BadFilter(f"a list of {size} identifiers: 0 to {LARGEST_LIST}")
    return MessageFilter(
        FormatFilter(standard_mode, standard_size, _STANDARD_BITS),
        FormatFilter(extended_mode, extended_size, _EXTENDED_BITS),
    )
