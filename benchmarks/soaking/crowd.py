"""Programs of all eight kinds on a hub: those that keep an account until the end, and those that are killed."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import canwire
from soaking.compiled import available
from soaking.interfaces import KINDS as PYTHON_KINDS
from soaking.kinds import command

PATIENCE_S = 90.0
KINDS = (*PYTHON_KINDS, *available())
_KEPT = {"canwire": "HW11", "vci": "HW12", "python-can": "HW13", "socketcan": "HW14", "acan": "HW15",
         "candrv": "HW16", "lin": "HW11", "c": "HW17", "c#": "HW18", "network": "HW19"}  # fmt: skip
_KILLED = {"canwire": "HW21", "vci": "HW22", "python-can": "HW23", "socketcan": "HW24", "acan": "HW25",
           "candrv": "HW26", "c": "HW21"}  # fmt: skip
CAN_BOARDS = tuple(dict.fromkeys([*_KEPT.values(), *_KILLED.values(), "HW1A", "HW1B"]))
PULLED = tuple(_KILLED.values())[:4]
"""Boards that are pulled and plugged while somebody uses them."""
LIN_LINE = 2


class Running:
    """A program in a process of its own, spoken to by lines."""

    everybody: ClassVar[set[subprocess.Popen[bytes]]] = set()

    def __init__(self, words: list[str], log: Path, address: str) -> None:
        environment = {**os.environ, "CANWIRE_HUB": address}
        with log.open("a") as said:
            self.process = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said, env=environment
            )
        self.log = log
        self.everybody.add(self.process)

    def line(self, patience_s: float = PATIENCE_S) -> str:
        """Its next line; raises AssertionError with what it said if none comes."""
        assert self.process.stdout is not None
        raw = self.process.stdout
        text = b""
        ends = time.monotonic() + patience_s
        while not text.endswith(b"\n"):
            ready, _, _ = select.select([raw], [], [], max(0.0, ends - time.monotonic()))
            byte = os.read(raw.fileno(), 1) if ready else b""
            if not byte:
                why = "has ended" if ready else "says nothing"
                raise AssertionError(f"{self.process.args} {why}: {self.log.read_text()[-2000:]}")
            text += byte
        return text.decode().strip()

    def say(self, word: str) -> None:
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(f"{word}\n".encode())
            self.process.stdin.flush()
        except BrokenPipeError:
            raise AssertionError(f"{self.process.args} has ended: {self.log.read_text()[-2000:]}") from None

    def account(self) -> dict[str, int]:
        self.say("account")
        told: dict[str, int] = json.loads(self.line())
        return told

    def kill(self) -> None:
        self.process.kill()
        self.end()

    def end(self) -> None:
        """Its input ends, and so does it."""
        with contextlib.suppress(BrokenPipeError):
            if self.process.stdin is not None:
                self.process.stdin.close()
        try:
            self.process.wait(PATIENCE_S)
        finally:
            self.process.kill()
            self.process.wait()
            self.everybody.discard(self.process)
            if self.process.stdout is not None:
                self.process.stdout.close()


class Crowd:
    """The eight kinds on one hub: `balance` at the end says what does not balance."""

    def __init__(self, hub: canwire.Hub, address: str, home: Path) -> None:
        self._hub, self._address, self._home = hub, address, home
        self._open: list[canwire.Lease] = []
        self._dongle, self._dongles_board = self._plugged_dongle("ttyKept")
        self._offer, self._offered = self._offered_hub()
        self.kept = {
            kind: self._start(kind, self._place(kind, _KEPT), number) for number, kind in enumerate(KINDS)
        }
        for program in self.kept.values():
            program.line()
        self._lines = {kind: hub.board(self._board(kind)).id for kind in KINDS}
        self._before = {kind: self._counts(kind) for kind in KINDS}
        for kind in KINDS:
            if kind != "lin":  # who recovers a line has something open on it
                self._open.append(hub.open_channel(self._lines[kind], 0))
        for program in self.kept.values():
            program.say("go")

    @property
    def lines(self) -> list[str]:
        """The CAN lines on the bus, as faults name them."""
        return [f"{board}:0" for board in (*CAN_BOARDS, self._dongles_board)]

    def victim(self, kind: str) -> Running:
        """One more program of a kind, on another board; wait for its line, and then have it `go`."""
        return self._start(kind, self._place(kind, _KILLED), 0x20 + list(KINDS).index(kind))

    def recover(self) -> int:
        """Whoever is bus-off begins again; how many."""
        count = 0
        for kind in KINDS:
            if (
                kind != "lin"
                and self._hub.line_status(self._lines[kind], 0).state == canwire.ErrorState.BUS_OFF
            ):
                self._hub.recover(self._lines[kind], 0)
                count += 1
        return count

    def settle(self) -> list[str]:
        """Nobody sends any more and the bus has carried everything: what does not balance, in words."""
        wrong: list[str] = []
        self._each(lambda _, program: program.say("stop"), wrong)
        self._until_quiet()
        self.accounts = {}
        self._each(lambda kind, program: wrong.extend(self._balance(kind, program.account())), wrong)
        for program in self.kept.values():
            program.end()
        for service in (self._dongle, self._offer):
            service.process.terminate()
            service.end()
        return wrong

    def _each(self, do: Callable[[str, Running], object], wrong: list[str]) -> None:
        """With every program that keeps an account; one that has ended is wrong, and only that."""
        for kind, program in list(self.kept.items()):
            try:
                do(kind, program)
            except AssertionError as error:
                wrong.append(f"{kind}: {error}")
                self.kept.pop(kind).end()

    def _balance(self, kind: str, account: dict[str, int]) -> list[str]:
        now, before = self._counts(kind), self._before[kind]
        received, sent = now[0] - before[0], now[1] - before[1]
        account |= {"line received": received, "line sent": sent}
        self.accounts[kind] = account
        missing = received - account["got"] - account["waiting"]  # `lost` counts events, too
        laws = {"received = read + waiting + lost": kind == "lin" or 0 <= missing <= account["lost"]}
        if "accepted" in account:
            there = account["taken out"] + account["in channel"] + account["lost in channel"]
            laws["accepted = read + waiting + lost"] = account["accepted"] == there
        if "sent" in account:
            left = account["aborted"] + account["refused"] + account["pending"]
            laws["handed over = sent"] = account["taken"] == account["sent"]
            laws["sent = delivered + aborted + refused + pending"] = (
                account["sent"] == account["delivered"] + left
            )
            laws["delivered = sent by the line"] = account["delivered"] == sent
        elif kind != "lin":
            laws["handed over = sent by the line"] = account["taken"] == sent
        return [f"{kind}: {law}: {account}" for law, holds in laws.items() if not holds]

    def _until_quiet(self) -> None:
        """Everything has gone out, as far as anything goes."""
        before, since = None, time.monotonic()
        ends = since + PATIENCE_S
        while time.monotonic() < ends and time.monotonic() - since < 2:
            self.recover()
            now = [self._counts(kind) for kind in KINDS]
            if now != before:
                before, since = now, time.monotonic()
            time.sleep(0.1)

    def _counts(self, kind: str) -> tuple[int, int]:
        board = self._lines[kind]
        status = (
            self._hub.lin_status(board, LIN_LINE).status if kind == "lin" else self._hub.line_status(board, 0)
        )
        return status.frames_received, status.frames_sent

    def _start(self, kind: str, place: str, number: int) -> Running:
        log = self._home / f"{kind}-{number}.log"
        address = self._offered if kind == "network" else self._address
        return Running(command(kind, address, place, number, self._home), log, self._address)

    def _offered_hub(self) -> tuple[Running, str]:
        """The hub as other machines find it, and its address there."""
        name = f"soak{os.getpid()}"
        words = ["offer", "--hub", self._address, "--name", name, "--listen", f"tcp/127.0.0.1:{_free_port()}"]
        running = Running([sys.executable, "-m", "canwire", *words], self._home / "offer.log", self._address)
        return running, next(word for word in running.line().split() if word.startswith("zenoh://"))

    def _plugged_dongle(self, name: str) -> tuple[Running, str]:
        words = [
            sys.executable,
            "-m",
            "canwire",
            "slcan",
            "--hub",
            self._address,
            "--pty",
            str(self._home / name),
        ]
        running = Running([*words, "--bus", "can0"], self._home / f"{name}.log", self._address)
        return running, running.line().partition("(")[2].partition(" ")[0]

    def _board(self, kind: str) -> str:
        return self._dongles_board if kind == "dongle" else _KEPT[kind]

    def _place(self, kind: str, boards: dict[str, str]) -> str:
        kept = boards is _KEPT
        other = {"dongle": str(self._home / "ttyKept"), "candrv": "CID1:" if kept else "CID2:"}
        if kind in other:
            return other[kind]
        return f"{boards[kind]}:0" if kind == "socketcan" else boards[kind]


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


VICTIMS = tuple(kind for kind in _KILLED if kind in KINDS)
