"""[candrv.*] in a TOML file: reads it, and changes single lines. All other lines and comments stay as they are.

A change is written to a temporary file, which then replaces the file in one step. If another program has changed the
file meanwhile, the file is read again. The contents before and after are compared: forms that cannot be changed line by
line (inline tables, dotted keys) are refused.
"""

from __future__ import annotations

import os
import re
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from canwire import BadConfig

SECTION = "candrv"
Value = int | str
_HEADER = re.compile(
    r"""\s*\[\s*(?:candrv|"candrv"|'candrv')\s*(?:\.\s*["']?([A-Za-z0-9_-]+)["']?\s*)?\]\s*(?:\#.*)?$"""
)
_KEY = re.compile(r"\s*[\"']?([A-Za-z0-9_-]+)[\"']?\s*=\s*")
_ATTEMPTS = 20


class Statement(NamedTuple):
    """A header, a key with its value, a blank line or a comment line: the characters `start` to `end` of the text."""

    start: int
    end: int
    value_end: int  # where a comment may begin


def load(path: Path) -> tuple[str, dict[str, dict[str, Value]] | None]:
    """The file's text, and the content of [candrv], which is None without such a table. Raises BadConfig."""
    try:
        text = path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        return "", None
    except OSError as error:
        raise BadConfig(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise BadConfig(f"{path}: byte {error.start} is no UTF-8: {error.reason}") from None
    return text, _section(_parsed(text, path), path)


def _parsed(text: str, path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadConfig(f"{path}: {error}") from None


def _section(data: dict[str, Any], path: Path) -> dict[str, dict[str, Value]] | None:
    found = data.get(SECTION)
    if found is not None and not (
        isinstance(found, dict) and all(isinstance(one, dict) for one in found.values())
    ):
        raise BadConfig(f"{path}: {SECTION} must have a table for each device, like [{SECTION}.CID1]")
    return found


Change = Callable[[dict[str, dict[str, Value]] | None], dict[str, dict[str, Value]]]


def change(path: Path, wanted: Change) -> None:
    """Change [candrv] to what `wanted` returns for its content. Raises BadConfig if that is impossible."""
    real = Path(os.path.realpath(path))
    for _ in range(_ATTEMPTS):
        text, before = load(real)
        after = wanted({name: dict(table) for name, table in before.items()} if before is not None else None)
        if after == before:
            return
        new = _edited(text, before, after)
        rest = {key: value for key, value in _parsed(text, real).items() if key != SECTION}
        try:
            unharmed = tomllib.loads(new) == {**rest, SECTION: after}
        except ValueError:
            unharmed = False
        if not unharmed:
            raise BadConfig(
                f"{path}: [{SECTION}.*] has a form that only an editor can change; write plain tables"
            )
        if _replaced(real, text, new):
            return
    raise BadConfig(f"{path}: other programs keep changing it")


def _replaced(path: Path, text: str, new: str) -> bool:
    """Replace the file by the new text; False if the file has changed meanwhile."""
    try:
        descriptor, beside = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(new.encode())
                file.flush()
                os.fsync(file.fileno())
            os.chmod(beside, path.stat().st_mode & 0o7777 if path.exists() else 0o644)
            if load(path)[0] != text:
                return False
            os.replace(beside, path)
            beside = ""
        finally:
            if beside:
                os.unlink(beside)
    except OSError as error:
        raise BadConfig(f"{path}: {error.strerror}") from None
    return True


# line by line


def _edited(text: str, before: dict[str, dict[str, Value]] | None, after: dict[str, dict[str, Value]]) -> str:
    newline = "\r\n" if "\r\n" in text else "\n"
    if before is None and not after:
        return _appended(text, f"[{SECTION}]", newline)
    for device in (before or {}).keys() - after.keys():
        text = _without_table(text, device, keep_section=not after)
    for device, table in after.items():
        old = (before or {}).get(device)
        if old is None:
            lines = [f"[{SECTION}.{device}]", *(f"{key} = {shown(value)}" for key, value in table.items())]
            text = _appended(text, newline.join(lines), newline)
            continue
        for key in old.keys() - table.keys():
            text = _without_key(text, device, key)
        for key, value in table.items():
            if old.get(key) != value:
                text = _with_key(text, device, key, value, newline)
    return text


def shown(value: Value) -> str:
    """A value in TOML: a number, or a basic string."""
    if isinstance(value, int):
        return str(value)
    escaped = re.sub(r'[\x00-\x1f\x7f"\\]', lambda found: f"\\u{ord(found[0]):04X}", value)
    return f'"{escaped}"'


def _appended(text: str, table: str, newline: str) -> str:
    blank = not text or text.endswith(2 * newline)
    gap = "" if blank else newline if text.endswith("\n") else 2 * newline
    return f"{text}{gap}{table}{newline}"


def _tables(text: str) -> list[tuple[str | None, int, int]]:
    """All tables: name ("" for [candrv], None outside it), and start and end of the table's text."""
    found: list[tuple[str | None, int, int]] = []
    for statement in statements(text):
        line = text[statement.start : statement.end]
        if line.lstrip().startswith("["):
            header = _HEADER.match(line.rstrip("\r\n"))
            if found:
                found[-1] = (*found[-1][:2], statement.start)
            found.append((header[1] or "" if header else None, statement.start, len(text)))
    return found


def _table(text: str, device: str) -> tuple[int, int]:
    spans = [(start, end) for name, start, end in _tables(text) if name == device]
    return spans[0] if spans else (len(text), len(text))


def _without_table(text: str, device: str, *, keep_section: bool) -> str:
    start, end = _table(text, device)
    trailing = re.search(r"(?:^[ \t]*(?:#[^\n]*)?\r?\n)*\Z", text[start:end], re.MULTILINE)
    kept = (
        text[start + trailing.start() : end] if trailing else ""
    )  # comments before the next table belong to that
    has_section = any(name == "" for name, _, _ in _tables(text))
    newline = "\r\n" if "\r\n" in text else "\n"
    section = f"[{SECTION}]{newline}" if keep_section and not has_section else ""
    return text[:start] + section + kept + text[end:]


def _keys(text: str, device: str) -> dict[str, tuple[Statement, int]]:
    """The statements of a table by their key, with the position at which the value begins."""
    start, end = _table(text, device)
    found = {}
    for statement in statements(text[start:end]):
        moved = Statement(*(start + place for place in statement))
        if key := _KEY.match(text, moved.start, moved.end):
            found[key[1]] = (moved, key.end())
    return found


def _without_key(text: str, device: str, key: str) -> str:
    statement = _keys(text, device).get(key)
    return text[: statement[0].start] + text[statement[0].end :] if statement else text


def _with_key(text: str, device: str, key: str, value: Value, newline: str) -> str:
    keys = _keys(text, device)
    if key in keys:
        statement, begin = keys[key]
        return text[:begin] + shown(value) + text[statement.value_end :]
    start, end = _table(text, device)
    last = max((statement.end for statement, _ in keys.values()), default=start)
    if last == start:
        first = text.find("\n", start, end)
        last = first + 1 if first >= 0 else end
    gap = "" if not last or text[last - 1] == "\n" else newline
    return f"{text[:last]}{gap}{key} = {shown(value)}{newline}{text[last:]}"


_PIECE = re.compile(
    r'"""(?:[^\\]|\\.)*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:[^"\\\n]|\\.)*"|\'[^\'\n]*\'|#[^\n]*|[\[{]|[\]}]|\n|[^"\'#\[\]{}\n]+',
    re.DOTALL,
)


def statements(text: str) -> list[Statement]:
    """The statements of a text; strings and arrays may extend over several lines."""
    found: list[Statement] = []
    start = depth = 0
    value_end = 0
    for piece in _PIECE.finditer(text):
        first = piece[0][0]
        if first == "\n" and depth <= 0:
            found.append(Statement(start, piece.end(), max(start, value_end)))
            start = value_end = piece.end()
            depth = 0
        elif first in "[{":
            depth += 1
        elif first in "]}":
            depth -= 1
        if first not in "#\n" and piece[0].strip():
            value_end = piece.start() + len(piece[0].rstrip())
    if start < len(text):
        found.append(Statement(start, len(text), max(start, value_end)))
    return found
