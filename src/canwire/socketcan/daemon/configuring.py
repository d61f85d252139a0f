"""`< can0 B ... >` and `< can0 C ... >`: stop a bus and set it up again before it is opened.

Source: linux-can/socketcand, doc/protocol.md and canctl.c: the words are copied into a struct can_bittiming.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from canwire import BadText, CanwireError
from canwire.socketcan.netlink.controller import LISTEN_ONLY, MODES, THREE_SAMPLES, TIMING
from canwire.socketcan.netlink.links import Refused, link_request

if TYPE_CHECKING:
    from collections.abc import Sequence

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.netlink.links import Links

_LOOPBACK = 0x1  # CAN_CTRLMODE_LOOPBACK, linux/can/netlink.h
_MODES = (LISTEN_ONLY, _LOOPBACK, THREE_SAMPLES)
_TIMING_WORDS = 8
_LARGEST = (1 << 31) - 1


def is_configuration(words: Sequence[str]) -> bool:
    """True if this is one of the two commands."""
    return len(words) > 1 and words[1] in ("B", "C")


def configure(links: Links, interface: Interface, words: Sequence[str]) -> None:
    """Execute one of them. Raises BadText for an invalid command, OSError if the bus cannot be set up like this."""
    data = (_timing if words[1] == "B" else _modes)(words[2:])
    try:
        links.change(interface, link_request(interface, up=False))
        links.change(interface, link_request(interface, data=data))
    except Refused as error:
        raise OSError(error.error, error.why) from None
    except CanwireError as error:
        raise OSError(str(error)) from None


def start(links: Links, interface: Interface) -> None:
    """Start the interface. Raises OSError."""
    try:
        links.change(interface, link_request(interface, up=True))
    except Refused as error:
        raise OSError(error.error, error.why) from None


def _timing(words: Sequence[str]) -> list[tuple[int, bytes]]:
    if len(words) != _TIMING_WORDS:
        raise BadText(
            "B: bitrate sample_point tq prop_seg phase_seg1 phase_seg2 sjw brp, -1 for a value that is left open"
        )
    try:
        values = [int(word) for word in words]
    except ValueError:
        raise BadText("B: eight whole numbers") from None
    if max(values) > _LARGEST:
        raise BadText(f"B: numbers up to {_LARGEST}")
    return [(TIMING, struct.pack("<8I", *(max(0, value) for value in values)))]


def _modes(words: Sequence[str]) -> list[tuple[int, bytes]]:
    if len(words) != len(_MODES) or set(words) - {"0", "1"}:
        raise BadText("C: listen_only loopback three_samples, each 0 or 1")
    flags = sum(flag for flag, word in zip(_MODES, words, strict=True) if word == "1")
    return [(MODES, struct.pack("<II", sum(_MODES), flags))]
