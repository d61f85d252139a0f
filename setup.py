"""Builds the compiled core; everything else about the package stands in pyproject.toml.

CANWIRE_BUILD chooses: "auto" (default) compiles where a compiler is found, "pure" never
compiles, "require" fails where compiling fails. `canwire --version` says which one runs.
"""

import os
import sys
from pathlib import Path

from setuptools import Extension, setup

MODE = os.environ.get("CANWIRE_BUILD", "auto")
CORE = [
    "canwire.values.frame",
    "canwire.values.slcan_text",
    "canwire.timeline",
    "canwire.ring",
    "canwire.bus.can.node",
    "canwire.bus.can.bits",
    "canwire.bus.can.bit_layout",
    "canwire.bus.can.frame_reader",
    "canwire.bus.can.tally",
    "canwire.bus.can.station",
    "canwire.bus.can.stimulus",
    "canwire.bus.can.bit_level",
    "canwire.bus.load",
    "canwire.bus.can.joining",
    "canwire.bus.can.stepped",
    "canwire.bus.can.bus_state",
    "canwire.bus.can.bus",
    "canwire.chips.confinement",
    "canwire.chips.host",
    "canwire.chips.ideal.can_fd",
    "canwire.chips.sja1000.interrupts",
    "canwire.chips.sja1000.fifo",
    "canwire.chips.sja1000.filter",
    "canwire.chips.sja1000.link",
    "canwire.chips.sja1000.modes",
    "canwire.chips.sja1000.controller",
    "canwire.drivers.driver",
    "canwire.drivers.can_fd",
    "canwire.boards.can.message_filter",
    "canwire.boards.can.channel",
    "canwire.boards.can.line",
]
DIRECTIVES = {
    "language_level": 3,
    "boundscheck": False,
    "wraparound": False,
    "initializedcheck": False,
    "cdivision": True,
    "annotation_typing": False,
    "freethreading_compatible": False,
}


def compiled_core() -> list[Extension]:
    """The core's extensions: each an ordinary Python source with its C types in the .pxd beside it."""
    from Cython.Build import cythonize

    extensions = [
        Extension(name, [f"src/{name.replace('.', '/')}.py"], extra_compile_args=optimisation())
        for name in CORE
    ]
    built: list[Extension] = cythonize(
        extensions, compiler_directives=DIRECTIVES, build_dir="build/cython", include_path=["src"]
    )
    for extension in built:  # cythonize drops the flag, so it is set on what it returns
        extension.optional = MODE != "require"
    return built


def optimisation() -> list[str]:
    return [] if sys.platform == "win32" else ["-O2", "-g0", "-fno-strict-aliasing"]


if MODE not in ("auto", "pure", "require"):
    sys.exit(f"CANWIRE_BUILD={MODE!r}: choose auto, pure or require")
os.chdir(Path(__file__).parent)
setup(
    ext_modules=[] if MODE == "pure" else compiled_core(),
    options={"build_ext": {"parallel": os.cpu_count() or 1}},
)
