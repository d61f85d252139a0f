"""Writes a file into the memory of an ECU, block by block: RequestDownload, TransferData, RequestTransferExit."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from canwire import BadValue
from canwire.commands.transport.line import load

_HEAD = 2  # of a TransferData request: service and block number


def flash(client: Any, words: Sequence[str]) -> None:
    """Write the file words[0] at the address words[1]. Raises BadValue, OSError, and the errors of udsoncan."""
    image = Path(words[0]).read_bytes()
    if not image:
        raise BadValue(f"flash: {words[0]} is empty")
    udsoncan = load("udsoncan")
    place = udsoncan.MemoryLocation(int(words[1], 16), len(image), 32, 32)
    longest = client.request_download(place).service_data.max_length - _HEAD
    if longest < 1:
        raise BadValue(
            f"flash: the ECU takes requests of {longest + _HEAD} bytes, which have no room for data"
        )
    progress = _Progress(len(image))
    for number, start in enumerate(range(0, len(image), longest), 1):
        client.transfer_data(number & 0xFF, image[start : start + longest])
        progress.show(min(start + longest, len(image)))
    client.request_transfer_exit()
    print(f"{len(image)} bytes to {words[1]}")


class _Progress:
    """Shows progress on stderr: on a terminal a line that changes, elsewhere a line for each tenth."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._tenths = 0
        self._live = sys.stderr.isatty()

    def show(self, done: int) -> None:
        """Show that `done` bytes are written."""
        text = f"{done} of {self._size} bytes, {100 * done // self._size} %"
        tenths = 10 * done // self._size
        if self._live:
            print(f"\r{text}", end="\n" if done == self._size else "", file=sys.stderr, flush=True)
        elif tenths > self._tenths:
            print(text, file=sys.stderr, flush=True)
        self._tenths = tenths
