"""What `canwire send` and `canwire dump` load before their first frame: nothing that only others need.

How long that takes is measured by benchmarks/startup.py.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

import canwire
from canwire import ChannelMode, WantedMode
from canwire.commands.can_line import bring_up
from canwire.commands.shared_hub import find_line

NOT_NEEDED = {
    "asyncio", "cantools", "can", "difflib", "json", "numpy", "tempfile", "textual",
    "canwire.boards.catalogue", "canwire.boards.lin.modes", "canwire.databases", "canwire.hub.handles.bus.bus",
    "canwire.hub.in_process", "canwire.hub.owner", "canwire.hub.protocol.lin_messages", "canwire.lab",
}  # fmt: skip
LOADED = """
import sys
from canwire.commands import main
status = main(sys.argv[1:])
print(status, *sorted(sys.modules))
"""


@pytest.mark.parametrize("words", ["send HW000001:0 123#11", "dump HW000001:0 -T 0"])
def test_only_what_is_needed_is_loaded(hub_address: str, words: str) -> None:
    with canwire.connect(hub_address) as hub:
        place = find_line(hub, "HW000001:1")
        with hub.open_channel(place.board.id, place.line) as channel:
            channel.set_up(ChannelMode(receive=1, transmit=1))
            bring_up(hub, place, WantedMode())
            command = [sys.executable, "-c", LOADED, *words.split(), "--hub", hub_address]
            ended = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    status, *modules = ended.stdout.split()
    assert status == "0"
    assert NOT_NEEDED & set(modules) == set()
