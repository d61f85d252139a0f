"""CANTERM, WCT and CANSPY from their words to their end; windows and drivers are loaded when they are asked for."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from importlib.util import find_spec
from typing import TYPE_CHECKING

from canwire import BadValue, ExtraMissing
from canwire.commands.acan.words import CLOCK_KHZ, RATE_KBPS, Words, machine, parsed
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire.acan import Driver
    from canwire.acan.install import Installation


def term(arguments: argparse.Namespace) -> int:
    """Run CANTERM."""
    words = parsed(arguments.words, "CR", "IEL")
    if len(words.rest) != 2:
        raise BadValue("two machine numbers are needed: LOCAL REMOTE, as in `canwire acan term 1 2`")
    local, remote = machine(words.rest[0], "local MID"), machine(words.rest[1], "remote MID")
    rates = _rates(words)
    from canwire.commands.acan.machines import set_up
    from canwire.commands.acan.term import Terminal
    from canwire.commands.acan.tty import converse, copy, ringing

    with ExitStack() as closing:
        bell = closing.enter_context(ringing())
        driver = _opened(arguments, "term", closing)
        local, remark = set_up(driver, local, *rates, force="I" in words.switches)
        _remark(driver)
        if remark:
            complain(remark)
        echo, loop = "E" in words.switches, "L" in words.switches
        terminal = Terminal(driver, local, remote, echo=echo, loop=loop, woken=bell.ring)
        closing.callback(terminal.close)
        terminal.open()
        greeting = f"CANTERM: machine {local} to {_whom(remote)}"
        if _is_screen():
            converse(terminal, bell, f"{greeting}; Ctrl-C ends")
        else:
            copy(terminal, bell, greeting, arguments.timeout)
    return 0


def wct(arguments: argparse.Namespace) -> int:
    """Run WCT in its window, or copy plain bytes."""
    from canwire.commands.acan.wct import overridden, read_settings

    words = parsed(arguments.words, "CR")
    if words.rest:
        raise BadValue(f"{words.rest[0]!r}: machine numbers are in {arguments.ini}")
    settings = overridden(read_settings(arguments.ini), words)
    screen = _is_screen()
    if screen:
        _need_textual()
    with ExitStack() as closing:
        if screen:
            from canwire.commands.acan.wct_screen import WctScreen

            driver = _opened(arguments, "wct", closing)
            return WctScreen(driver, settings, arguments.ini).finish()
        from canwire.commands.acan.tty import copy, ringing
        from canwire.commands.acan.wct import Wct

        bell = closing.enter_context(ringing())
        driver = _opened(arguments, "wct", closing)
        running = Wct(driver, settings, bell.ring)
        closing.callback(running.stop)
        running.start()
        _remark(driver)
        greeting = f"WCT: machine {settings.local} to {_whom(settings.target)}"
        copy(running.terminal, bell, greeting, arguments.timeout)
    return 0


def spy(arguments: argparse.Namespace) -> int:
    """Run CANSPY in its window, or print plain lines."""
    words = parsed(arguments.words, "CR")
    if words.rest:
        raise BadValue(f"{words.rest[0]!r}: CANSPY takes no words but /C: and /R:")
    if arguments.count is not None and arguments.count < 1:
        raise BadValue(f"-n {arguments.count}: 1 or more")
    rates = _rates(words)
    screen = _is_screen() and arguments.count is None
    if screen:
        _need_textual()
    with ExitStack() as closing:
        if not screen:
            return _spy_in_lines(arguments, rates, closing)
        from canwire.commands.acan.spy_screen import SpyScreen

        driver = _opened(arguments, "spy", closing)
        return SpyScreen(driver, rates, arguments.redirect, arguments.send).finish()


def _spy_in_lines(arguments: argparse.Namespace, rates: tuple[int, int], closing: ExitStack) -> int:
    from canwire.commands.acan.spy import Spy, Trace, clock
    from canwire.commands.acan.tty import follow, ringing

    bell = closing.enter_context(ringing())
    trace = Trace(clock, print)
    driver = _opened(arguments, "spy", closing)
    running = Spy(driver, trace, bell.ring)
    closing.callback(running.stop)
    trace.redirect(arguments.redirect)
    running.start(*rates)
    _remark(driver)
    for message in arguments.send:
        running.send(message)
    follow(running, bell, arguments.count)
    return 0


def install(arguments: argparse.Namespace, installation: Installation | None) -> int:
    """The driver for that board; None: no driver any more."""
    from canwire.acan.install import install, uninstall

    with ExitStack() as closing:
        hub = connected(arguments, "acan install", closing)
        if installation is None:
            uninstall(hub)
            print("ACAN is not installed any more")
        else:
            board = install(hub, installation)
            print(f"ACAN is installed for {board.hardware_id}: {installation.to_arguments()}")
    return 0


def _opened(arguments: argparse.Namespace, program: str, closing: ExitStack) -> Driver:
    """The driver on a shared hub; raises DriverAbsent, HubError."""
    from canwire import acan

    hub = connected(arguments, f"acan {program}", closing)
    if arguments.board is None:
        return closing.enter_context(acan.open(hub))
    return closing.enter_context(acan.open(hub, board=arguments.board))


def _remark(driver: Driver) -> None:
    from canwire.commands.acan.machines import rate_remarks

    for line in rate_remarks(driver):
        complain(line)


def _rates(words: Words) -> tuple[int, int]:
    """Return the clock in kHz and the bit rate in kbit/s."""
    return words.number("C", CLOCK_KHZ), words.number("R", RATE_KBPS)


def _whom(remote: int) -> str:
    return f"machine {remote}" if remote else "all machines"


def _is_screen() -> bool:
    """Whether somebody sits at both ends."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def _need_textual() -> None:
    if find_spec("textual") is None:
        raise ExtraMissing("textual", "tools")
