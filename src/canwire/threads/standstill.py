"""The message for a program whose threads all wait for an event that cannot come."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from types import FrameType

from canwire.threads.member import Member
from canwire.threads.originals import select_select

_HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
_LIBRARY = os.path.dirname(os.path.abspath(os.__file__))


def describe(members: Sequence[Member], since_ns: int) -> str:
    """Return text that lists what each thread waits for, and where."""
    frames = sys._current_frames()
    waits = [
        f"thread {one.thread.name!r} waits for {one.what}{place(frames.get(one.thread.ident or 0))}"
        for one in members
    ]
    return (
        f"nothing can end this wait: since {since_ns / 1e9:.9f} s every thread waits without a timeout, and nothing "
        f"comes for an hour of the hub's time: {'; '.join(waits)}"
    )


def place(frame: FrameType | None) -> str:
    """Return the innermost line outside canwire and the standard library, as text."""
    while frame is not None:
        name = frame.f_code.co_filename
        if not name.startswith((_HERE, _LIBRARY, "<frozen")):
            return f" ({name}:{frame.f_lineno})"
        frame = frame.f_back
    return ""


def wait_for_descriptors(descriptors: Sequence[int], text: str | None) -> None:
    """Wait in real time: the other ends of the descriptors may be outside this program."""
    if text is not None:
        print(f"canwire: {text}; waiting for descriptors of the outside world", file=sys.stderr, flush=True)
    select_select(descriptors, (), (), None)
