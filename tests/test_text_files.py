"""Text files are the same on every system: each place that opens one says its encoding, and what ends a line it writes.

Windows would take cp1252 else, and end lines with CR and LF.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

SOURCES = Path(__file__).parent.parent / "src" / "canwire"
NO_FILES = (
    "os.devnull",
    "handle",
    "self.handle",
    "self._handle",
    "device",
)  # the last are candrv's, whose texts are ASCII
THE_SYSTEMS = ("pytest_plugin.py:read_text",)  # what programs wrote on their standard streams
MODE = {
    "open": 1,
    "write_text": None,
    "read_text": None,
    "NamedTemporaryFile": 0,
}  # where a call has its mode


def test_encoding_and_ends_of_lines_are_said() -> None:
    assert [fault for path in sorted(SOURCES.rglob("*.py")) for fault in faults(path)] == []


def test_a_fault_is_found(tmp_path: Path) -> None:
    bad = tmp_path / "bad.py"
    bad.write_text(
        "open(p)\nopen(p, 'w', encoding='utf-8')\npath.write_text(t)\npath.open('rb')\nopen(p, 'wb')\n"
        "path.write_text(t, encoding='utf-8', newline='')\n"
    )
    assert [fault.partition(":")[2] for fault in faults(bad)] == ["1", "2", "3"]


def faults(path: Path) -> Iterator[str]:
    """FILE:LINE of calls that leave it to the system."""
    text = path.read_text("utf-8")
    if not any(name in text for name in MODE):
        return  # most files: parsing all of them takes a second
    for call in ast.walk(ast.parse(text)):
        if not isinstance(call, ast.Call) or (name := name_of(call.func)) not in MODE:
            continue
        if no_file(call) or f"{path.name}:{name}" in THE_SYSTEMS:
            continue
        given = {word.arg for word in call.keywords}
        mode = "w" if name == "write_text" else mode_of(call, name)
        if mode is None or "b" in mode:
            continue
        wanted = {"encoding"} | ({"newline"} if set(mode) & set("wax+") else set())
        given |= {"encoding"} if name == "read_text" and call.args else set()
        if not wanted <= given:
            yield f"{path.name}:{call.lineno}"


def no_file(call: ast.Call) -> bool:
    """Standard streams by their numbers, and what has only the names of these calls."""
    first = call.func.value if isinstance(call.func, ast.Attribute) else (call.args or [ast.Constant(0)])[0]
    return ast.unparse(first) in NO_FILES or (
        isinstance(first, ast.Constant) and isinstance(first.value, int)
    )


def name_of(function: ast.expr) -> str:
    """Of open(...) and of anything.write_text(...); a method `open` counts where its first word is a mode."""
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def mode_of(call: ast.Call, name: str) -> str | None:
    """Its mode as text, None for a call that opens no file of text by what stands there."""
    if name == "read_text":
        return "r"
    place = MODE[name] or 0
    method = isinstance(call.func, ast.Attribute) and name == "open"
    words = [word.value for word in call.keywords if word.arg == "mode"] + call.args[
        0 if method else place :
    ][:1]
    if not words:
        return "r" if name == "open" and not method else None
    return str(words[0].value) if isinstance(words[0], ast.Constant) and is_mode(words[0].value) else None


def is_mode(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 3 and set(value) <= set("rwaxbt+")
