"""CANSPY without its screen: its banner, its trace, the last messages sent.

While it runs, the controller accepts all frames, and no other program can change that; afterwards the filters are
restored.
Source: INduCAN104 manual, "CAN Spy (CANSPY)".
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from canwire import Frame, acan
from canwire.commands.acan.conditions import WATCHED, news
from canwire.commands.acan.trace import format_message, format_trace_line, parse_message
from canwire.commands.acan.words import CLOCK_KHZ, RATE_KBPS

if TYPE_CHECKING:
    from canwire.acan import Driver, HardConfig, TaskBlock

TITLE = "CAN Spy - Version 1.0"
CREDIT = "*** canwire's own, made after the manual of the INduCAN104 board"
MESSAGES = 800  # kept
SENT = 10  # kept
_PRIORITY = 1  # 0 would show a message that never was on the bus
_PATIENCE_S = 1.0  # for room in the driver's queue


def banner(version: tuple[int, int], config: HardConfig, *, before: bool) -> list[str]:
    """The heading of a trace; `before`: the controller was initialised already."""
    number = f"{version[0]}.{version[1]}"
    return [
        TITLE,
        CREDIT,
        "",
        f"ACAN.DLL Version {number}",
        "",
        f"VACAND Driver Version {number}",
        "",
        "Philips SJA1000 CAN Controller detected",
        f"Hardware was {'previously' if before else 'not'} initialized",
        "",
        *config.banner().splitlines(),
        "",
    ]


def clock() -> str:
    """The time of day, hh:mm:ss."""
    return time.strftime("%H:%M:%S")


class Trace:
    """Lines: the last 800 messages and the lines between them. `show` gets each line, as does the file.

    `clock` gives the time as hh:mm:ss.
    """

    def __init__(self, clock: Callable[[], str], show: Callable[[str], None]) -> None:
        self.on = False
        self.taken = 0  # messages shown
        self._clock = clock
        self._show = show
        self._lines: deque[tuple[str, bool]] = deque(maxlen=2 * MESSAGES)  # is it a message?
        self._messages = 0
        self._passed = 0
        self._file: TextIO | None = None

    def __len__(self) -> int:
        return len(self._lines)

    @property
    def lines(self) -> list[str]:
        return [line for line, _ in self._lines]

    def write(self, line: str) -> None:
        """Add a line unchanged."""
        self._add(line, message=False)

    def note(self, what: str) -> None:
        """Add a line that begins with the time."""
        self._add(f"{self._clock()} - {what}", message=False)

    def take(self, frames: Iterable[Frame]) -> None:
        """Show messages with the present time; while the trace is off, only count them."""
        for frame in frames:
            if self.on:
                self._add(format_trace_line(self._clock(), frame), message=True)
                self.taken += 1
            else:
                self._passed += 1

    def resume(self) -> None:
        """Turn the trace on, and note how many messages passed by."""
        if self._passed:
            self.note(f"{self._passed} messages passed by")
        self.on, self._passed = True, 0
        self.note("TRACE IS ON")

    def pause(self) -> None:
        self.on = False
        self.note("TRACE IS OFF")

    def clear(self) -> None:
        """Remove every line from memory; a file keeps its lines."""
        self._lines.clear()
        self._messages = 0

    def redirect(self, path: Path | None) -> None:
        """Lines from now on go to the end of that file, too; None: no more. Raises OSError."""
        file = path.open("a", encoding="utf-8", newline="\n") if path else None
        self.close()
        self._file = file

    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def flush(self) -> None:
        """What was written is in the file; a full disk ends the redirection, and a line says so."""
        try:
            if self._file is not None:
                self._file.flush()
        except OSError as error:
            self._lose_file(error)

    def _add(self, line: str, *, message: bool) -> None:
        if len(self._lines) == self._lines.maxlen:
            self._forget()
        self._lines.append((line, message))
        self._messages += message
        while self._messages > MESSAGES:
            self._forget()
        self._show(line)
        try:
            if self._file is not None:
                self._file.write(line + "\n")
        except OSError as error:
            self._lose_file(error)

    def _forget(self) -> None:
        self._messages -= self._lines.popleft()[1]

    def _lose_file(self, error: OSError) -> None:
        file, self._file = self._file, None
        with suppress(OSError):  # closing it fails the same way
            if file is not None:
                file.close()
        self.note(f"no longer redirected: {error}")


class Spy:
    """The trace of one driver. `woken` is called, on the driver's thread, when there is something to `take`."""

    def __init__(self, driver: Driver, trace: Trace, woken: Callable[[], None] = lambda: None) -> None:
        self.trace = trace
        self.sent: deque[str] = deque(maxlen=SENT)  # the newest first
        self._driver = driver
        self._woken = woken
        self._closing = ExitStack()
        self._block: TaskBlock | None = None

    def start(self, clock_khz: int = CLOCK_KHZ, rate_kbps: int = RATE_KBPS) -> None:
        """Print the banner, open the filters and start the trace. Clock and rate apply to an uninitialised controller.

        Raises InUse if another program holds the filters, BadTiming.
        """
        before, was_on = self._driver.config(), self._driver.on_bus
        base = before or acan.HardConfig(0, 0, 0, 0, clock_khz=clock_khz, rate_kbps=rate_kbps)
        config = replace(base, machine_mask=0, broadcast_mask=0)
        with ExitStack() as closing:
            closing.enter_context(self._driver.hold_filters())
            if before is not None:
                closing.callback(self._put_back, before, was_on)
            self._driver.configure(config)
            block = acan.TaskBlock(
                [acan.Filter.any()], conditions=WATCHED, size=MESSAGES, notify=lambda block: self._woken()
            )
            self._driver.register(block)
            closing.callback(self._driver.deregister, block)
            self._driver.bus_on()
            self._closing = closing.pop_all()
        self._block = block
        for line in banner(self._driver.version, config, before=before is not None):
            self.trace.write(line)
        self.trace.note("Hardware is initialized")
        self.trace.resume()

    def stop(self) -> None:
        """No more messages; the filters are what they were. Stopped already, it stays so."""
        self._block = None
        self._closing.close()
        self.trace.close()

    def take(self, limit: int | None = None) -> None:
        """Put received messages into the trace, at most `limit` of them (None: all)."""
        block = self._block
        if block is None:
            return
        found = news(block)
        self.trace.take(block.retrieve(limit))
        for line in found.lines:
            self.trace.note(line)
        self.trace.flush()

    def check(self) -> None:
        """Raises HubLost or Unplugged if nothing can come any more."""
        if self._block is not None:
            self._block.wait(0)

    def toggle(self) -> None:
        """Pause or resume; resuming, a controller that left the bus goes back."""
        self.take()
        if self.trace.on:
            self.trace.pause()
            return
        if not self._driver.on_bus:
            self._driver.bus_on()
        self.trace.resume()

    def send(self, text: str) -> None:
        """One message in the trace's notation. Raises BadText, BadFrame, QueueFull."""
        frame = parse_message(text)
        self._driver.send(frame, _PRIORITY, _PATIENCE_S)
        shown = format_message(frame)
        if shown in self.sent:
            self.sent.remove(shown)
        self.sent.appendleft(shown)
        self.trace.note(f"Sent: {shown}")

    def _put_back(self, config: HardConfig, was_on: bool) -> None:
        self._driver.configure(config)
        if was_on:
            self._driver.bus_on()
