"""WCT without its screen: WCT.INI, and settings that take effect immediately.

    [WCT]
    Clock=16000
    Rate=250
    Local=1
    Target=2
    Echo=0
    Loop=0

Source: INduCAN104 manual, "Windows CAN Terminal (WCT)".
"""

from __future__ import annotations

import configparser
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from canwire import BadConfig, BadValue, CanwireError
from canwire.commands.acan.ini import ini_encoding, ini_text
from canwire.commands.acan.machines import config_of, configure
from canwire.commands.acan.term import Terminal
from canwire.commands.acan.words import CLOCK_KHZ, MID_MAX, RATE_KBPS, Words

if TYPE_CHECKING:
    from canwire.acan import Driver

SECTION = "WCT"
_RANGES = {
    "clock": (1, 0xFFFF),
    "rate": (1, 0xFFFF),
    "local": (1, MID_MAX),
    "target": (0, MID_MAX),
    "echo": (0, 1),
    "loop": (0, 1),
}
_NOTES = {
    "clock": ", kHz",
    "rate": ", kbit/s",
    "local": ", this machine",
    "target": ", 0 for all machines",
}


@dataclass(frozen=True)
class Settings:
    """What WCT.INI has: kHz, kbit/s, machine numbers, and two switches, 0 or 1. Raises BadValue naming the entry."""

    clock: int = CLOCK_KHZ
    rate: int = RATE_KBPS
    local: int = 1
    target: int = 0
    echo: int = 0
    loop: int = 0

    def __post_init__(self) -> None:
        for name, (least, most) in _RANGES.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise BadValue(f"{name.capitalize()}={value}: {least} to {most}{_NOTES.get(name, '')}")

    @classmethod
    def of_texts(cls, texts: dict[str, str]) -> Settings:
        """Settings from entries by their names in small letters; missing ones have their defaults. Raises BadValue."""
        numbers = {}
        for name in _RANGES:
            if name not in texts:
                continue
            text = texts[name].strip()
            if not (text.isascii() and text.isdigit()):
                raise BadValue(f"{name.capitalize()}={text}: a decimal number")
            numbers[name] = int(text)
        return cls(**numbers)

    @classmethod
    def hints(cls) -> dict[str, str]:
        """What each entry may be."""
        return {
            name.capitalize(): f"{least} to {most}{_NOTES.get(name, '')}"
            for name, (least, most) in _RANGES.items()
        }

    def texts(self) -> dict[str, str]:
        """Entries of the file, by their names there."""
        return {name.capitalize(): str(value) for name, value in asdict(self).items()}


def read_settings(path: Path) -> Settings:
    """[WCT] of that file; the usual settings without one. Raises BadConfig naming the file."""
    ini = _parser(path)
    section = _section(ini)
    try:
        return Settings.of_texts({name.lower(): value for name, value in _items(ini, section)})
    except BadValue as error:
        raise BadConfig(f"{path}: [{SECTION}] {error}") from None


def overridden(settings: Settings, words: Words) -> Settings:
    """/C: and /R: instead of the file's. Raises BadValue."""
    clock, rate = words.number("C", settings.clock), words.number("R", settings.rate)
    return replace(settings, clock=clock, rate=rate)


def write_settings(path: Path, settings: Settings) -> None:
    """Into [WCT] of that file; other sections stay. Raises BadConfig, OSError."""
    ini = _parser(path)
    section = _section(ini) or SECTION
    others = {name: value for name, value in _items(ini, section) if name.lower() not in _RANGES}
    ini[section] = {**settings.texts(), **others}
    encoding = ini_encoding(path) if path.exists() else "utf-8"
    with path.open("w", encoding=encoding, errors="surrogateescape", newline="\r\n") as file:
        ini.write(file, space_around_delimiters=False)


class _Ini(configparser.ConfigParser):
    """Names as they are written."""

    def optionxform(self, optionstr: str) -> str:
        return optionstr


def _parser(path: Path) -> configparser.ConfigParser:
    ini = _Ini(interpolation=None, strict=False)
    try:
        if path.exists():
            ini.read_string(ini_text(path), str(path))
    except configparser.Error as error:
        raise BadConfig(f"{path}: {' '.join(str(error).split())}") from None
    return ini


def _section(ini: configparser.ConfigParser) -> str:
    return next((name for name in ini.sections() if name.upper() == SECTION), "")


def _items(ini: configparser.ConfigParser, section: str) -> list[tuple[str, str]]:
    return list(ini[section].items()) if ini.has_section(section) else []


class Wct:
    """A terminal with settings; `terminal` is there while it runs. `woken` as in acan_term.Terminal."""

    def __init__(self, driver: Driver, settings: Settings, woken: Callable[[], None] = lambda: None) -> None:
        self.settings = settings
        self._driver = driver
        self._woken = woken
        self.terminal = self._terminal(settings)

    def start(self) -> None:
        """Initialise the controller, whatever it was, and receive. Raises InUse, BadTiming, BadValue."""
        self._initialise(self.settings)
        self.terminal.open()

    def stop(self) -> None:
        self.terminal.close()

    def apply(self, settings: Settings) -> None:
        """Immediately. Raises what `start` raises; then everything is as it was."""
        before = self.settings
        hardware = replace(settings, target=before.target, echo=before.echo, loop=before.loop)
        if hardware != before:
            try:
                self._initialise(settings)
            except CanwireError:
                self._initialise(before)
                raise
        if settings.local != before.local:
            self.terminal.close()
            self.terminal = self._terminal(settings)
            self.terminal.open()
        self.terminal.remote = settings.target
        self.terminal.echo, self.terminal.loop = bool(settings.echo), bool(settings.loop)
        self.settings = settings

    def _initialise(self, settings: Settings) -> None:
        configure(self._driver, config_of(settings.local, settings.clock, settings.rate))
        self._driver.bus_on()

    def _terminal(self, settings: Settings) -> Terminal:
        return Terminal(
            self._driver,
            settings.local,
            settings.target,
            echo=bool(settings.echo),
            loop=bool(settings.loop),
            woken=self._woken,
        )
