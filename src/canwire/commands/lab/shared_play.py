"""A log onto a line that programs share: every frame at its time, counted once another controller acknowledged it."""

from __future__ import annotations

import argparse
import json
import time
from contextlib import ExitStack

from canwire import BadValue, ChannelMode
from canwire.commands.can_line import bring_up, wanted_by
from canwire.commands.console import complain
from canwire.commands.lab.candump_log import CandumpLog, Survey
from canwire.commands.lab.progress import Progress
from canwire.commands.send import Sending
from canwire.commands.shared_hub import connected, find_line

_QUEUE = 1024
_PATIENCE_S = 1.0


def play_shared(arguments: argparse.Namespace, log: CandumpLog, found: Survey) -> int:
    """Play it; 1 if frames were not delivered, or lines are broken and --strict asks for none.

    Raises BadValue for a speed below 0 and for frames that the line cannot send, HubError without a hub.
    """
    speed = 1.0 if arguments.speed is None else arguments.speed
    patience_s = _PATIENCE_S if arguments.timeout is None else arguments.timeout
    for name, value in (("speed", speed), ("timeout", patience_s)):
        if not value >= 0:
            raise BadValue(f"--{name} {value}: 0 or more")
    with ExitStack() as closing:
        hub = connected(arguments, "play", closing)
        place = find_line(hub, arguments.line, to_send=True)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=1, transmit=_QUEUE, frames=False))
        bring_up(hub, place, wanted_by(arguments))
        channel.activate()
        complain(f"{found.frames} frames onto {place.address} on {place.info.bus}")
        sending = Sending(hub, place, channel, patience_s)
        with Progress(found.lines, "playing") as progress:
            _send_all(log, found, sending, speed, progress)
        status = sending.result()
        _report(arguments, found, sending.delivered)
    return 1 if status or (arguments.strict and found.broken_lines) else 0


def _send_all(log: CandumpLog, found: Survey, sending: Sending, speed: float, progress: Progress) -> None:
    """Queue every frame when it is due; until the queue stays full."""
    begin_s = time.monotonic()
    for number, frame in log.frames():
        if speed:
            due_s = begin_s + (frame.timestamp_ns - found.first_ns) / 1e9 / speed
            time.sleep(max(0.0, due_s - time.monotonic()))
        progress.show(number)
        if not sending.queue(frame):
            return


def _report(arguments: argparse.Namespace, found: Survey, delivered: int) -> None:
    facts = {"frames": found.frames, "delivered": delivered, "broken_lines": found.broken_lines,
             "error_frames_skipped": found.error_frames}  # fmt: skip
    if arguments.json:
        print(json.dumps(facts, indent=2))
        return
    print(f"{delivered} of {found.frames} frames delivered")
