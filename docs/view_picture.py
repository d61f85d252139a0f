"""Draws docs/view.svg: the window of `canwire view` on a small bus in virtual time, always the same.

python docs/view_picture.py
"""

from __future__ import annotations

import asyncio
import random
import re
from contextlib import ExitStack
from itertools import islice
from pathlib import Path

from textual.widgets import Footer

import canwire
from canwire import ChannelMode, Frame, Hub, HubChannel, WantedMode
from canwire.commands.can_line import bring_up
from canwire.commands.gen.cyclic import CyclicMessages
from canwire.commands.live.decoding import decoder
from canwire.commands.live.listening import Listening, places_of
from canwire.commands.shared_hub import find_line
from canwire.commands.view.rows import Rows
from canwire.commands.view.screen import ViewScreen
from canwire.commands.view.table import Table

PAGE = Path(__file__).resolve().parent / "view.svg"
DATABASE = Path(__file__).resolve().parent.parent / "tests" / "commands" / "car.dbc"
FRAMES = 300
SIZE = (118, 20)


def sender_on(hub: Hub, address: str, closing: ExitStack) -> HubChannel:
    place = find_line(hub, address)
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(ChannelMode(receive=1, transmit=64))
    bring_up(hub, place, WantedMode())
    channel.activate()
    return channel


def traffic(hub: Hub, sender: HubChannel) -> None:
    """The database's messages by their cycle times, and some that it does not know."""
    messages = CyclicMessages(str(DATABASE), [], 0.5, random.Random(1))
    for number, (gap_s, frame) in enumerate(islice(messages.plan(), FRAMES)):
        hub.run_for(gap_s)
        sender.send(frame)
        if number % 20 == 0:
            sender.send(Frame(0x7E8, bytes([number // 20, 0x41, 0x0C])))
            sender.send(Frame(0x18FF1234, bytes(8), extended=True))
    hub.run_for(0.01)


def _has_keys(footer: Footer) -> bool:
    return bool(footer.children) and all(key.region for key in footer.children)


async def drawn(screen: ViewScreen) -> str:
    async with screen.run_test(size=SIZE) as pilot:
        screen.query_one(Rows).action_move(1)
        screen.look()
        await pilot.pause()
        while not _has_keys(screen.query_one(Footer)):  # on a busy machine a pause ends before all is shown
            await pilot.pause()
        return screen.export_screenshot(title="canwire view can0 --db car.dbc")


def picture() -> str:
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        listening = closing.enter_context(Listening(hub, places_of(hub, ["can0"]), WantedMode()))
        traffic(hub, sender_on(hub, "HW000001:1", closing))
        text = asyncio.run(drawn(ViewScreen(listening, Table(), decoder(str(DATABASE)))))
    return re.sub(r"terminal-\d+", "view", text)


if __name__ == "__main__":
    PAGE.write_text(picture(), encoding="utf-8")
