"""CanSend of the CANDRV manual: many messages on many channels from many threads, with totals and errors.

Every thread sends its own identifier, from 100h on in the order of channels and threads, and counts in the first four
data bytes, the highest first; channel and thread follow. So a receiver can tell what is missing or out of order.
Source: CANDRV manual, 10.1; the rest is ours.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import Counter
from contextlib import ExitStack
from typing import IO, TYPE_CHECKING

from canwire import CanwireError
from canwire.commands.candrv.opening import (
    DEVICE_ERROR,
    MESSAGES,
    OK,
    failed,
    hub_of,
    log_file,
    open_device,
    point_out,
    say,
    set_rate,
)
from canwire.commands.candrv.switches import Switches
from canwire.commands.candrv.work import work
from canwire.commands.shell.progress import Progress

if TYPE_CHECKING:
    from canwire.candrv import Handle

FIRST_ID = 0x100
WRITE_TIMEOUT_MS = 1000  # a message that finds no room for so long is an error
_IN_A_ROW = 3  # failures after which a thread gives up: it would wait as long for each message that is left
_USUAL = {"n": MESSAGES, "c": 1, "t": 1}
_SILENCE_S = 0.5  # what the controller has not sent by then it will not send
_LOOK_S = 0.02
_TELL_S = 1.0
_TRIES, _BETWEEN_S = 100, 0.002


def can_send(switches: Switches, closing: ExitStack) -> int:
    """Send the messages; returns 1 if any was not sent."""
    counts, channels, threads = (switches.numbers.get(letter, usual) for letter, usual in _USUAL.items())
    hub = hub_of(switches, closing)
    handles = [closing.enter_context(open_device(switches, hub, write=True)) for _ in range(channels)]
    rate = set_rate(switches, handles[0])
    point_out(handles[0])
    with log_file(switches) as log:
        total = counts * channels * threads
        start = (
            f"Start sending {counts} messages x {channels} channels x {threads} threads = {total} messages "
            f"to {switches.device}, baudrate={rate} Hz"
        )
        stress = Stress(handles, threads, counts, log)
        try:
            work(lambda: stress.run(start), stress.stop)
        finally:
            for line in stress.summary():
                say(line)
    return OK if stress.sent == total else DEVICE_ERROR


class Stress:
    """`threads` threads on every handle, each sending `count` messages."""

    def __init__(self, handles: list[Handle], threads: int, count: int, log: IO[bytes] | None) -> None:
        self._handles = handles
        self.threads = threads
        self._log = log
        self._log_lock = threading.Lock()
        self._senders = [
            Sender(self, handle, channel, thread, count)
            for channel, handle in enumerate(handles)
            for thread in range(threads)
        ]
        self._total = count * len(self._senders)
        self.sent = 0  # that have been on the bus
        self._seconds = 0.0
        self.stopping = False
        for handle in handles:
            timeouts = handle.timeouts
            timeouts.WriteTotalTimeoutConstant = WRITE_TIMEOUT_MS
            handle.timeouts = timeouts

    @property
    def taken(self) -> int:
        """Messages that the driver has taken."""
        return sum(sender.taken for sender in self._senders)

    @property
    def errors(self) -> Counter[str]:
        """Calls that failed, by what they said."""
        found: Counter[str] = Counter()
        for sender in self._senders:
            found.update(sender.errors)
        return found

    def run(self, start: str) -> None:
        """Run until everything is sent, sending has stalled, or `stop`; raises Failure when the device is gone."""
        say(start)
        begun = time.monotonic()
        try:
            for sender in self._senders:
                sender.start()
            self._watch()
            self._drain()
        except CanwireError as error:
            raise failed("Send error", error) from error
        finally:
            self.stopping = True
            self._seconds = time.monotonic() - begun

    def stop(self) -> None:
        """Send no further messages."""
        self.stopping = True

    def _watch(self) -> None:
        lines_due = time.monotonic() + _TELL_S
        with Progress(self._total, "sending") as progress:
            while any(sender.is_alive() for sender in self._senders):
                time.sleep(_LOOK_S)
                done = sum(sender.done for sender in self._senders)
                progress.show(done)
                if not sys.stdout.isatty() and time.monotonic() >= lines_due:
                    lines_due += _TELL_S
                    say(f"{done} of {self._total}")

    def _drain(self) -> None:
        """Wait for the send buffers; what does not go out is taken back."""
        waiting, moved = self._count(), time.monotonic()
        while waiting and time.monotonic() - moved < _SILENCE_S and not self.stopping:
            time.sleep(_LOOK_S)
            before, waiting = waiting, self._count()
            if waiting != before:
                moved = time.monotonic()
        for _ in range(_TRIES):
            for handle in self._handles:
                handle.abort()
            if not self._count():
                return
            time.sleep(_BETWEEN_S)  # one that is on the wire ends first, well or badly

    def _count(self) -> int:
        """How many messages wait, with `sent` brought up to date."""
        found = [handle.sending for handle in self._handles]
        self.sent = sum(one.sent for one in found)
        return sum(one.waiting for one in found)

    def summary(self) -> list[str]:
        """The totals, and each kind of error once."""
        lines = [
            f"{self.sent} of {self._total} messages sent in {self._seconds:.3f} s, "
            f"{self.sent / self._seconds if self._seconds else 0:.0f} messages/s"
        ]
        if given_up := self.taken - self.sent:
            lines.append(f"{given_up} given up: the controller could not send them")
        lines.append(f"{sum(self.errors.values())} errors")
        lines += [f"  {count} x {what}" for what, count in sorted(self.errors.items())]
        return lines

    def log(self, identifier: int, data: bytes) -> None:
        """A line of the log, as CanWrite writes it."""
        if self._log is not None:
            line = f"{identifier:x} 0 8 {' '.join(f'{byte:x}' for byte in data)}\n".encode()
            with self._log_lock:
                self._log.write(line)


class Sender(threading.Thread):
    """One thread on one channel; it ends early when it gets nowhere."""

    def __init__(self, stress: Stress, handle: Handle, channel: int, thread: int, count: int) -> None:
        super().__init__(daemon=True)
        self._stress, self._handle = stress, handle
        self._channel, self._thread, self._count = channel, thread, count
        self.taken = self.done = 0
        self.errors: Counter[str] = Counter()

    def run(self) -> None:
        """The messages one after the other; a failed one is counted and not tried again."""
        from canwire.candrv.errors import format_error, win32_code
        from canwire.candrv.filters import aligned

        handle = self._handle
        state, align = handle.device.state(), handle.device.settings.align
        number = FIRST_ID + self._channel * self._stress.threads + self._thread
        identifier = aligned(number, state.extended, align)
        place = bytes([self._channel, self._thread, 0, 0])
        in_a_row = 0
        for message in range(self._count):
            data = message.to_bytes(4, "big") + place
            try:
                handle.write_message(identifier, data)
            except CanwireError as error:
                self.errors[format_error(win32_code(error))] += 1
                in_a_row += 1
            else:
                self.taken += 1
                in_a_row = 0
                self._stress.log(identifier, data)
            self.done = message + 1
            if self._stress.stopping or in_a_row == _IN_A_ROW:
                return
