"""INI files as Windows programs left them: in UTF-8, or in the code page of their system.

Source: INduCAN104 manual, "Windows setup"; their bytes are kept as they are.
"""

from __future__ import annotations

from pathlib import Path

_UTF_8, _WINDOWS = "utf-8-sig", "cp1252"


def ini_encoding(path: Path) -> str:
    """The encoding to read and write this file with, with the error handler "surrogateescape". Raises OSError."""
    try:
        path.read_bytes().decode(_UTF_8)
    except UnicodeDecodeError:
        return _WINDOWS
    return "utf-8"


def ini_text(path: Path) -> str:
    """The contents of the file; bytes that are no characters come back as they were. Raises OSError."""
    encoding = ini_encoding(path)
    return path.read_text(encoding if encoding == _WINDOWS else _UTF_8, errors="surrogateescape")
