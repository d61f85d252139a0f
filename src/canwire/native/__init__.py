"""The libraries and headers for programs in C and C++, and the helper process of these programs.

docs/native.md is for users; "How an interface in C is built" in docs/architecture.md is for developers of canwire.
"""

from __future__ import annotations

import os
import sys

from canwire import Unsupported

_HERE = os.path.dirname(os.path.abspath(__file__))


def include_directory() -> str:
    """Return the directory with the headers."""
    return os.path.join(_HERE, "include")


def library_directory(*, windows: bool = sys.platform == "win32") -> str:
    """Return the directory with the libraries, for Linux or Windows; raises Unsupported if they were not built."""
    if windows:
        return _windows_directory()
    if not os.path.exists(os.path.join(_HERE, "lib", "libcanwire.so")):
        raise Unsupported(
            "the libraries for C and C++ are missing: they are built with canwire on Linux if a compiler is found"
        )
    return os.path.join(_HERE, "lib")


def _windows_directory() -> str:
    made = os.path.join(_HERE, "lib", "windows")
    if not os.path.exists(os.path.join(made, "vciapi.dll")):
        raise Unsupported(
            "the libraries for Windows are missing: bash .ci/dlls builds them in canwire's sources with mingw-w64"
        )
    return made


def cmake_directory() -> str:
    """Return the directory with canwire-config.cmake."""
    return os.path.join(_HERE, "cmake")


def pkg_config_directory() -> str:
    """Return the directory with the files for pkg-config."""
    return os.path.join(_HERE, "pkgconfig")
