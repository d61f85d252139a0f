"""The functions that calculate a key from a seed: `canwire uds --key`."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

from canwire import BadValue

Key = Callable[[int, bytes], bytes]


def key_by(text: str) -> Key:
    """The function that `text` names; raises BadValue."""
    if text == "invert":
        return lambda level, seed: bytes(each ^ 0xFF for each in seed)
    if text.startswith("xor:"):
        return _xor(text)
    path, colon, name = text.rpartition(":")
    if not (colon and path.endswith(".py")):
        raise BadValue(f"--key {text}: invert, xor:HEX, or FILE.py:FUNCTION")
    return _of_file(text, Path(path), name)


def _xor(text: str) -> Key:
    try:
        mask = bytes.fromhex(text.removeprefix("xor:"))
    except ValueError:
        mask = b""
    if not mask:
        raise BadValue(f"--key {text}: bytes in hex, xor:5A")
    return lambda level, seed: bytes(each ^ mask[at % len(mask)] for at, each in enumerate(seed))


def _of_file(text: str, path: Path, name: str) -> Key:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None or not path.exists():
        raise BadValue(f"--key {text}: there is no file {path}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    found = getattr(module, name, None)
    if not callable(found):
        raise BadValue(f"--key {text}: {path} has no function {name}(level, seed)")

    def key(level: int, seed: bytes) -> bytes:
        made = found(level, seed)
        if not isinstance(made, bytes):
            raise BadValue(f"--key {text}: it gave {made!r}, not bytes")
        return made

    return key
