"""Programs in C and C++ on canwire: the libraries and headers that they are built with, and the helper behind them.

docs/native.md is for their users, "How an interface in C is built" in docs/architecture.md for who adds one.
"""

from __future__ import annotations

import os
import sys

from canwire import Unsupported

_HERE = os.path.dirname(os.path.abspath(__file__))


def include_directory() -> str:
    """Where the headers are."""
    return os.path.join(_HERE, "include")


def library_directory(*, windows: bool = sys.platform == "win32") -> str:
    """Where the libraries are, those for Linux or for Windows; raises Unsupported where they were not built."""
    if windows:
        return _windows_directory()
    if not os.path.exists(os.path.join(_HERE, "lib", "libcanwire.so")):
        raise Unsupported(
            "the libraries for C and C++ are not here: they are built with canwire on Linux where compilers are found"
        )
    return os.path.join(_HERE, "lib")


def _windows_directory() -> str:
    made = os.path.join(_HERE, "lib", "windows")
    if not os.path.exists(os.path.join(made, "vciapi.dll")):
        raise Unsupported(
            "the libraries for Windows are not here: bash .ci/dlls makes them in canwire's sources, by mingw-w64"
        )
    return made


def cmake_directory() -> str:
    """Where canwire-config.cmake is."""
    return os.path.join(_HERE, "cmake")


def pkg_config_directory() -> str:
    """Where the files for pkg-config are."""
    return os.path.join(_HERE, "pkgconfig")
