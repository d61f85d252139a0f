"""`canwire native`: what a build needs to know for programs in C, C++ and .NET, written for VCI, CANDRV or ACAN.

canwire native --cflags --libs              options for g++, VCI V4 (vcisdk.h)
canwire native vcinpl2 --cflags --libs      options for gcc or g++, the flat interface with CAN FD (vcinpl2.h)
canwire native candrv --cflags --libs       the same for CANDRV (canbusio.h), and acan for ACAN.H
canwire native dotnet --libs                references for mcs, Ixxat.Vci4 and Ixxat.Vci3
canwire native dotnet --libraries           where these assemblies are: what MONO_PATH takes
canwire native --windows --cflags --libs    options for x86_64-w64-mingw32-g++: the same for Windows
canwire native --windows --libraries        where vciapi.dll, vcinpl.dll and vcinpl2.dll are, to copy beside a program
canwire native --cmake                      what cmake's -Dcanwire_DIR takes, for find_package(canwire)
canwire native --pkg-config                 what PKG_CONFIG_PATH takes, for pkg-config vciapi

As in g++ sample.cpp $(canwire native --cflags --libs) -o sample. The programs find the hub as every program does:
CANWIRE_HUB, else the user's usual one. docs/native.md has the rest.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys

from canwire import BadValue
from canwire.native import cmake_directory, dotnet, include_directory, library_directory, pkg_config_directory

INTERFACES = {
    "vciapi": ("vciapi",),
    "vcinpl": ("vcinpl", "vciapi"),
    "vcinpl2": ("vcinpl2", "vciapi"),
    "candrv": ("candrv",),
    "acan": ("acan",),
}
LINUX_ALONE = ("candrv", "acan")
DOTNET = "dotnet"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "interface",
        nargs="?",
        default="vciapi",
        choices=[*INTERFACES, DOTNET],
        help="which one (default: vciapi)",
    )
    parser.add_argument("--cflags", action="store_true", help="print the compiler's options")
    parser.add_argument("--libs", action="store_true", help="print the linker's options")
    parser.add_argument(
        "--includes", action="store_true", help="print where the headers are, or .NET's sources"
    )
    parser.add_argument("--libraries", action="store_true", help="print where the libraries are")
    parser.add_argument(
        "--windows",
        action="store_true",
        default=sys.platform == "win32",
        help="with these four: for programs for Windows, by mingw-w64",
    )
    parser.add_argument("--cmake", action="store_true", help="print where canwire-config.cmake is")
    parser.add_argument("--pkg-config", action="store_true", help="print where the files for pkg-config are")


def run(arguments: argparse.Namespace) -> int:
    """Print the requested options in one line.

    BadValue for nothing, and for what .NET or Windows have not; Unsupported where no libraries were built, or no
    compiler is.
    """
    words = _dotnet(arguments) if arguments.interface == DOTNET else _libraries(arguments)
    if not words:
        raise BadValue("say what to print: canwire native --cflags --libs")
    print(shlex.join(words))
    return 0


def _libraries(arguments: argparse.Namespace) -> list[str]:
    if arguments.windows and arguments.interface in LINUX_ALONE:
        raise BadValue(f"{arguments.interface} is there for Linux alone, not for Windows")
    words: list[str] = []
    if arguments.cflags:
        words += ["-idirafter", include_directory()] if arguments.windows else [f"-I{include_directory()}"]
    if arguments.libs:
        words += _linked(arguments.interface, windows=arguments.windows)
    if arguments.includes:
        words.append(include_directory())
    if arguments.libraries:
        words.append(library_directory(windows=arguments.windows))
    if arguments.cmake:
        words.append(cmake_directory())
    if arguments.pkg_config:
        words.append(pkg_config_directory())
    return words


def _dotnet(arguments: argparse.Namespace) -> list[str]:
    if arguments.cflags or arguments.cmake or arguments.pkg_config:
        raise BadValue(
            "dotnet has --libs (mcs's references), --libraries (assemblies) and --includes (sources)"
        )
    words: list[str] = []
    if arguments.libs:
        words += [f"-r:{os.path.join(dotnet.assembly_directory(), name)}" for name in dotnet.NAMES]
    if arguments.includes:
        words.append(dotnet.source_directory())
    if arguments.libraries:
        words.append(dotnet.assembly_directory())
    return words


def _linked(interface: str, *, windows: bool) -> list[str]:
    """Return linker options; a Windows library needs no other one, and GCC's runtime is linked statically to it."""
    home = library_directory(windows=windows)
    if windows:
        return [f"-L{home}", f"-l{interface}", "-luuid", "-static-libgcc", "-static-libstdc++"]
    return [f"-L{home}", f"-Wl,-rpath,{home}", *(f"-l{name}" for name in (*INTERFACES[interface], "canwire"))]
