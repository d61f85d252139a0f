"""Collects signals of a line of the hub, from now on."""

from __future__ import annotations

import argparse
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import WantedMode, record_dtype
from canwire.commands.live.listening import RECORD, Listening, complain_each, places_of
from canwire.commands.plot.decoding import Decoding
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire.commands.plot.choosing import Chosen
    from canwire.commands.plot.tracks import Tracks

_USUAL_S = 10.0
_BATCH = 4096


def listen_for_tracks(arguments: argparse.Namespace, chosen: Chosen, tracks: Tracks) -> None:
    """Collect samples from a line for --seconds; raises NoSuchBoard, HubError."""
    import numpy

    seconds = _USUAL_S if arguments.seconds is None else arguments.seconds
    decoding = Decoding(chosen, tracks)
    with ExitStack() as closing:
        hub = connected(arguments, "plot", closing)
        wanted = WantedMode(arguments.bit_rate, arguments.data_bit_rate)
        listening = closing.enter_context(Listening(hub, places_of(hub, [arguments.source]), wanted))
        complain_each(listening.told)

        def now_s() -> float:
            return hub.now_ns() / 1e9 if hub.virtual else time.monotonic()

        zero_ns, end_s = hub.now_ns(), now_s() + seconds
        while (left_s := end_s - now_s()) > 0:
            for source, records in listening.take(_BATCH, left_s):
                timely = [record for record in records if zero_ns <= record[0] <= zero_ns + seconds * 1e9]
                block = bytearray(b"".join(RECORD.pack(*record) for record in timely))
                decoding.add(source.name, numpy.frombuffer(block, record_dtype()), zero_ns)
        for source in listening.sources:
            if lost := listening.counted(source).lost:
                complain_each([f"{source.name}: {lost} lost"])
