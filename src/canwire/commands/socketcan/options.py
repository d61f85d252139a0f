"""--interface, for both SocketCAN verbs."""

from __future__ import annotations

import argparse


def add_interface_argument(parser: argparse.ArgumentParser) -> None:
    """Add --interface."""
    parser.add_argument(
        "--interface",
        action="append",
        default=[],
        metavar="NAME=LINE",
        help="another name for a bus or a line: vcan0=can0, can0=HW000001:0; may be given several times",
    )


def mappings_of(arguments: argparse.Namespace) -> dict[str, str]:
    """Return the line of each --interface, by the interface's name. Raises BadValue."""
    from canwire.socketcan.interfaces import parse_mapping

    return dict(parse_mapping(text) for text in arguments.interface)
