"""Words of a command line: a mistake shows the usage of the verb that it was made in, however deep that is."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

_USUAL = 80  # columns
TIMES = {
    "real": "as the clock goes",
    "fast": "with the clock while buses rest, without waiting while they work",
    "lockstep": "virtual, and one for all programs that take part (CANWIRE_TIMED=1), who run in turns",
    "virtual": "without waiting, the same every time",
}


class Help(argparse.RawDescriptionHelpFormatter):
    """Formats help with a module's text unchanged. argparse makes one for each option: it must load little."""

    def __init__(self, prog: str, *arguments: Any, **options: Any) -> None:
        options.setdefault("width", _columns() - 2)
        super().__init__(prog, *arguments, **options)


def _columns() -> int:
    """Return the terminal's width as shutil.get_terminal_size does, without loading shutil's compressors."""
    given = os.environ.get("COLUMNS", "")
    if given.isdigit() and int(given):
        return int(given)
    try:
        return os.get_terminal_size(sys.__stdout__.fileno()).columns or _USUAL  # type: ignore[union-attr]
    except (AttributeError, ValueError, OSError):  # no terminal, or closed
        return _USUAL


class Parser(argparse.ArgumentParser):
    """A parser whose verb reports the words that it does not know; argparse has the topmost parser do so.

    The message for an unknown word names the nearest word that the verb knows. Where a verb accepts several words,
    options may be written between them.
    """

    _mixing = False

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self._has_negative_number_optionals.clear()  # -8 may be an option, and -1.0 is a value all the same
        if self._mixing:
            return super().parse_known_args(args, namespace)
        if self._takes_several():
            self._mixing = True
            try:
                found, unknown = self.parse_known_intermixed_args(args, namespace)
            finally:
                self._mixing = False
        else:
            found, unknown = super().parse_known_args(args, namespace)
        if unknown and self._subparsers is None:
            self.error(f"unrecognized arguments: {' '.join(unknown)}{self._meant(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        """Exit with the message; of missing arguments it names only the required ones."""
        head, required, names = message.partition("are required: ")
        if required:
            optional = {one.metavar for one in self._get_positional_actions() if one.nargs in ("*", "?")}
            names = ", ".join(name for name in names.split(", ") if name not in optional)
        super().error(head + required + names)

    def format_help(self) -> str:
        """Return the usage, the verb's text with its most common uses, and then every option."""
        formatter = self.formatter_class(prog=f"{self.prog} [options]")
        formatter.add_usage(None, self._get_positional_actions(), [])
        formatter.add_text(self.description)
        for group in self._action_groups:
            formatter.start_section(group.title)
            formatter.add_text(group.description)
            formatter.add_arguments(group._group_actions)
            formatter.end_section()
        formatter.add_text(self.epilog)
        return formatter.format_help()

    def _takes_several(self) -> bool:
        counts = [action.nargs for action in self._get_positional_actions()]
        return bool({"+", "*"} & set(counts)) and not {argparse.PARSER, argparse.REMAINDER} & set(counts)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            near = _near(str(value), [str(choice) for choice in action.choices])
            if near:
                raise argparse.ArgumentError(action, f"invalid choice: {value!r}; did you mean {near}?")
        super()._check_value(action, value)

    def _meant(self, unknown: Sequence[str]) -> str:
        near = [_near(word.partition("=")[0], self._option_string_actions) for word in unknown]
        return "".join(f"; did you mean {one}?" for one in near if one)


def _near(word: str, known: Iterable[str]) -> str:
    from difflib import get_close_matches

    return next(iter(get_close_matches(word, known, 1)), "")


def add_time_argument(parser: argparse._ActionsContainer, offered: Sequence[str], why_not: str) -> None:
    """Add --time, with the same names in every verb; the first one of `offered` is the default.

    A name that means something elsewhere is refused with `why_not`.
    """

    def name(text: str) -> str:
        if text in TIMES and text not in offered:
            raise argparse.ArgumentTypeError(f"{text}: {why_not}; {' or '.join(offered)}")
        if text not in offered:
            raise argparse.ArgumentTypeError(f"{text!r}: {' or '.join(offered)}")
        return text

    meanings = "; ".join(f"{one}: {TIMES[one]}" for one in offered)
    parser.add_argument(
        "--time", type=name, metavar=f"{{{','.join(offered)}}}", help=f"{meanings} (default: {offered[0]})"
    )
