"""A log onto lines that programs share: every frame at its time, counted once another controller acknowledged it."""

from __future__ import annotations

import argparse
import json
import time
from contextlib import ExitStack
from itertools import count

from canwire import BadValue, Frame, Hub, format_frame
from canwire.commands.can_line import open_sender, wanted_by
from canwire.commands.console import complain
from canwire.commands.lab.any_log import AnyLog
from canwire.commands.lab.candump_log import CandumpLog, Survey
from canwire.commands.logs.choosing import parsed_map
from canwire.commands.send import Sending
from canwire.commands.shared_hub import connected
from canwire.commands.shell.progress import Progress

_QUEUE = 1024
_PATIENCE_S = 1.0


class Targets:
    """Which line each channel of the log goes onto: `rest` for channels that are not named, None: they are left out."""

    def __init__(self, lines: list[str], maps: list[str]) -> None:
        self.of_channel = parsed_map(maps)
        plain = [line for line in lines if "=" not in line]
        for line in lines:
            name, equals, channel = line.partition("=")
            if equals and self.of_channel.setdefault(channel, name) != name:
                raise BadValue(f"{line}: {channel} goes onto {self.of_channel[channel]} already")
        if len(plain) > 1:
            raise BadValue(f"{' '.join(plain)}: one line for the whole log, or LINE=CHANNEL for each channel")
        self.rest = plain[0] if plain else None

    @property
    def lines(self) -> list[str]:
        """Every line that something goes onto, once."""
        return list(dict.fromkeys([*self.of_channel.values(), *([self.rest] if self.rest else [])]))

    def line(self, channel: str) -> str | None:
        return self.of_channel.get(channel, self.rest)


class Senders:
    """A channel of the hub's for each line."""

    def __init__(self, arguments: argparse.Namespace, targets: Targets, closing: ExitStack) -> None:
        self._targets = targets
        self._patience_s = _PATIENCE_S if arguments.timeout is None else arguments.timeout
        hub = connected(arguments, "play", closing)
        self._by_line = {line: self._opened(arguments, hub, line, closing) for line in targets.lines}

    def _opened(self, arguments: argparse.Namespace, hub: Hub, line: str, closing: ExitStack) -> Sending:
        place, channel = open_sender(hub, line, wanted_by(arguments), _QUEUE, closing)
        return Sending(hub, place, channel, self._patience_s)

    def queue(self, frame: Frame, channel: str) -> bool:
        """Send it from its channel's line, if there is one; False where a queue stays full."""
        line = self._targets.line(channel)
        return line is None or self._by_line[line].queue(frame)

    def line(self, channel: str) -> str | None:
        """The line to which frames of this channel go; None if they are not sent."""
        return self._targets.line(channel)

    def result(self) -> int:
        """Wait until the buses have taken all; 1 if something is missing, which is said."""
        return max(sending.result() for sending in self._by_line.values())

    @property
    def delivered(self) -> int:
        return sum(sending.delivered for sending in self._by_line.values())


def play_shared(arguments: argparse.Namespace, log: CandumpLog | AnyLog, found: Survey) -> int:
    """Play it; 1 if frames were not delivered, or lines are broken and --strict asks for none.

    Raises BadValue for a speed below 0 and for frames that the line cannot send, HubError without a hub.
    """
    for name in ("speed", "timeout", "gap", "loop", "skip"):
        value = getattr(arguments, name)
        if value is not None and not value >= 0:
            raise BadValue(f"--{name} {value}: 0 or more")
    targets = Targets(arguments.line, arguments.map)
    unknown = sorted(set(targets.of_channel) - set(found.channels))
    if unknown:
        raise BadValue(
            f"--map: the log has no channel {', '.join(unknown)}; it has {', '.join(found.channels)}"
        )
    played = {channel: number for channel, number in found.channels.items() if targets.line(channel)}
    with ExitStack() as closing:
        senders = Senders(arguments, targets, closing)
        frames = sum(played.values())
        left = found.frames - frames
        others = f"; {left} of other channels left out" if left else ""
        complain(f"{frames} frames onto {', '.join(targets.lines)}{others}")
        with Progress(found.lines, "playing") as progress:
            rounds = _send_all(arguments, log, found, senders, progress)
        status = senders.result()
        _report(arguments, frames * rounds, found, senders.delivered)
    return 1 if status or (arguments.strict and found.broken_lines) else 0


def _send_all(
    arguments: argparse.Namespace,
    log: CandumpLog | AnyLog,
    found: Survey,
    senders: Senders,
    progress: Progress,
) -> int:
    """Queue every frame when it is due, as often as asked for, until a queue stays full; how many rounds were begun."""
    speed = 1.0 if arguments.speed is None else arguments.speed
    gap_s = (arguments.gap or 0.0) / 1000
    loop = 1 if arguments.loop is None else arguments.loop
    for number in count(1) if loop == 0 else range(1, loop + 1):
        begin_s = time.monotonic()
        before_ns, left_out_ns = found.first_ns, 0
        for line, frame, channel in log.frames():
            if arguments.skip is not None and frame.timestamp_ns - before_ns > arguments.skip * 1e9:
                left_out_ns += frame.timestamp_ns - before_ns
            before_ns = frame.timestamp_ns
            if speed:
                due_s = begin_s + (frame.timestamp_ns - left_out_ns - found.first_ns) / 1e9 / speed
                time.sleep(max(0.0, due_s - time.monotonic()))
            progress.show(line)
            if not senders.queue(frame, channel):
                return number
            if arguments.verbose:
                print(f"{senders.line(channel) or '-'} {format_frame(frame)}")
            if gap_s:
                time.sleep(gap_s)
        if not found.frames:
            return number
    return loop


def _report(arguments: argparse.Namespace, frames: int, found: Survey, delivered: int) -> None:
    facts = {"frames": frames, "delivered": delivered, "broken_lines": found.broken_lines,
             "error_frames_skipped": found.error_frames}  # fmt: skip
    if arguments.json:
        print(json.dumps(facts, indent=2))
        return
    print(f"{delivered} of {frames} frames delivered")
