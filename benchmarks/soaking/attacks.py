"""What happens to a hub, its programs, their boards and wires, one thing after another."""

from __future__ import annotations

import contextlib
import socket
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from random import Random

import canwire
from soaking.crowd import PULLED, VICTIMS, Crowd, Running
from soaking.honest import Honest
from soaking.hostile import HOSTILE
from soaking.trouble import Trouble
from soaking.wire import Wire

_MOST_VICTIMS = 4


class Attacks:
    """`one` is the next attack; some go on beside the next ones until they are killed."""

    def __init__(
        self, honest: Honest, crowd: Crowd, trouble: Trouble, home: Path, random: Random, done: Counter[str]
    ) -> None:
        self._trouble = trouble
        self._honest, self._crowd, self._home = honest, crowd, home
        self._random, self.done = random, done
        self._hub = canwire.connect(honest.address, name="disturbs wires")
        self._wire = Wire(self._hub, "can0", "lin0", crowd.lines, random)
        self._wire.struck = done
        self._victims: dict[str, Running] = {}
        self._all: list[Callable[[], None]] = (
            [self.wire] * 24 + [self.storm, self.victim] * 3 + [self.rubbish, self.half_messages, self.boards,
            self.short, self.pull, trouble.stop, trouble.stop, trouble.stop, trouble.set_clock, trouble.full_disk,
            trouble.lockstep, trouble.stop_hub]
        )  # fmt: skip

    def one(self) -> None:
        self._trouble.look()
        self._random.choice(self._all)()

    def end(self) -> None:
        """Nothing is wrong any more, and nobody is left but who keeps an account."""
        self._trouble.end()
        self._wire.mend()
        for kind in list(self._victims):
            self._kill(kind)
        self._crowd.recover()

    def wire(self) -> None:
        """Another fault, while programs go on; whoever is bus-off comes back."""
        self._wire.strike()
        time.sleep(self._random.uniform(0, 0.2))
        self.done["recovered from bus-off"] += self._crowd.recover()

    def storm(self) -> None:
        """Some hostile programs at once, killed in the middle of it."""
        kinds = self._random.sample(sorted(HOSTILE), 4)
        log = self._home / "hostile.log"
        address = self._honest.address
        programs = [
            Running([sys.executable, "-c", HOSTILE[kind], address, kind], log, address) for kind in kinds
        ]
        for program in programs:
            assert program.line() == "at it", log.read_text()
        for _ in range(5):
            self.wire()
            self._honest.exchange(20)
        for program, kind in zip(programs, kinds, strict=True):
            program.kill()
            self.done[f"killed: hostile {kind}"] += 1

    def victim(self) -> None:
        """A program of one of the kinds joins, or is killed if it is there."""
        kind = self._random.choice(VICTIMS)
        if kind in self._victims or len(self._victims) >= _MOST_VICTIMS:
            self._kill(kind if kind in self._victims else self._random.choice(list(self._victims)))
            return
        victim = self._victims[kind] = self._crowd.victim(kind)
        with contextlib.suppress(AssertionError):  # it was told why it cannot, its board being pulled
            victim.line()
            victim.say("go")

    def _kill(self, kind: str) -> None:
        self._victims.pop(kind).kill()
        self.done[f"killed: {kind}"] += 1

    def rubbish(self) -> None:
        """Connections that say anything at all."""
        for _ in range(50):
            with socket.socket(socket.AF_UNIX) as wire, contextlib.suppress(OSError):
                wire.connect(self._honest.address)
                wire.sendall(self._random.randbytes(self._random.randrange(1, 4000)))
        self.done["random connections"] += 50

    def half_messages(self) -> None:
        wires = [socket.socket(socket.AF_UNIX) for _ in range(50)]
        for wire in wires:
            wire.connect(self._honest.address)
            wire.sendall(b"\x40\0\0\0half")
        self._honest.exchange(10)
        for wire in wires:
            wire.close()
        self.done["half messages"] += 50

    def boards(self) -> None:
        """In and out again, with somebody on them who sends."""
        try:
            plugger = canwire.connect(self._honest.address, name="plugger")
        except canwire.HubLost:  # it answers nobody who has waited for so long: its machine is that busy
            self.done["connections without an answer in time"] += 1
            return
        with plugger as hub:
            for _ in range(10):
                plugged = hub.plug("usb-to-can", buses=("can0", ""))
                with hub.open_control(plugged.id, 0) as control:
                    control.initialise(
                        canwire.LineMode(canwire.BitTiming.for_bit_rate(500_000, clock_hz=36_000_000))
                    )
                    channel = hub.open_channel(plugged.id, 0)
                    channel.set_up(canwire.ChannelMode(64, 64))
                    channel.activate()
                    control.start()
                for number in range(20):
                    channel.send(canwire.Frame(0x7A0, bytes([number])))
                time.sleep(self._random.uniform(0, 0.02))
                hub.unplug(plugged.hardware_id)
        self.done["boards pulled"] += 10

    def pull(self) -> None:
        """A board that a program may be using is pulled and plugged again."""
        serial = self._random.choice(PULLED)
        self._wire.mend()
        self._hub.unplug(serial)
        lin = "lin0" if serial == PULLED[0] else ""
        self._hub.plug("usb-to-can-fd", serial, ("can0", "", lin))
        self.done["boards pulled from under a program"] += 1

    def short(self) -> None:
        self._honest.short()
        self.done["can1 shorted"] += 1
