"""Builds the compiled core; everything else about the package stands in pyproject.toml.

CANWIRE_BUILD chooses: "auto" (default) compiles where a compiler is found, "pure" never
compiles, "require" fails where compiling fails. `canwire --version` says which one runs.
"""

import os
import sys
import sysconfig
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

MODE = os.environ.get("CANWIRE_BUILD", "auto")
CORE = {  # and the compiler's -O: nine tenths of the core's work is done at level 2, the rest compiles quicker
    "canwire.values.frame": 2,
    "canwire.values.slcan_text": 1,
    "canwire.values.packed_records": 3,
    "canwire.timeline": 2,
    "canwire.ring": 3,
    "canwire.bus.can.node": 1,
    "canwire.bus.can.bits": 3,
    "canwire.bus.can.bit_layout": 2,
    "canwire.bus.can.frame_reader": 2,
    "canwire.bus.can.tally": 1,
    "canwire.holding": 1,
    "canwire.bus.can.station": 2,
    "canwire.bus.can.stimulus": 2,
    "canwire.bus.can.echo": 2,
    "canwire.bus.can.clock": 2,
    "canwire.bus.can.reader_state": 2,
    "canwire.bus.can.coasting": 2,
    "canwire.bus.can.drifting": 2,
    "canwire.bus.can.bit_level": 2,
    "canwire.bus.load": 1,
    "canwire.bus.can.joining": 1,
    "canwire.bus.can.stepped": 2,
    "canwire.bus.can.bus_state": 2,
    "canwire.bus.can.bus": 3,
    "canwire.bus.lin.node": 0,
    "canwire.bus.lin.bus": 1,
    "canwire.chips.confinement": 1,
    "canwire.chips.host": 1,
    "canwire.chips.ideal.can_fd": 2,
    "canwire.chips.lin.controller": 1,
    "canwire.chips.sja1000.interrupts": 2,
    "canwire.chips.sja1000.fifo": 2,
    "canwire.chips.sja1000.filter": 2,
    "canwire.chips.sja1000.link": 2,
    "canwire.chips.sja1000.modes": 1,
    "canwire.chips.sja1000.controller": 2,
    "canwire.drivers.driver": 2,
    "canwire.drivers.can_fd": 2,
    "canwire.boards.can.message_filter": 1,
    "canwire.boards.can.channel": 3,
    "canwire.boards.can.line": 3,
    "canwire.boards.can.sending": 2,
    "canwire.hub.owner.pace": 1,
    "canwire.hub.owner.loop": 1,
    "canwire.hub.owner.lockstep.turns": 1,
    "canwire.hub.owner.lockstep.program": 1,
    "canwire.hub.owner.lockstep.shared_page": 1,
    "canwire.hub.owner.lockstep.keeper": 1,
    "canwire.hub.owner.lockstep.pace": 1,
    "canwire.hub.protocol.turn_page": 1,
}
SHIM = "canwire.socketcan._shim"
NATIVE = "canwire.native.lib."
LIBRARIES = {  # for programs in C and C++: folders of native/ that they are made of, and what of these they need
    "libcanwire": (("core", "windows"), ()),
    "libacan": (("acanapi",), ("canwire",)),
    "libcandrv": (("candrvapi",), ("canwire",)),
    "libvciapi": (("vciapi",), ("canwire",)),
    "libvcinpl": (("flat", "vcinpl"), ("vciapi", "canwire")),
    "libvcinpl2": (("flat", "vcinpl2"), ("vciapi", "canwire")),
}
DIRECTIVES = {
    "language_level": 3,
    "boundscheck": False,
    "wraparound": False,
    "initializedcheck": False,
    "cdivision": True,
    "nonecheck": True,  # an attribute of what was never initialised is None: AttributeError, where C would read on
    "annotation_typing": False,
    "allow_none_for_extension_args": False,  # None is not a Frame: TypeError, where C would read its fields
    "auto_pickle": False,  # Frame says itself how it is pickled, everything else is one of a kind
    "freethreading_compatible": False,
}
PROCESSES = os.cpu_count() or 1


class BuildCore(build_ext):
    """Sources become C when the core is built, not when somebody asks for the package's name and version."""

    command_name = "build_ext"  # what its warnings begin with

    def run(self) -> None:
        plain = [extension for extension in self.extensions if extension.name not in CORE]
        self.extensions = [extension for extension in self.extensions if extension.name in CORE]
        if self.extensions:
            self.translate()
        self.extensions += plain
        super().run()

    def build_extensions(self) -> None:
        """In tiers, each of them side by side: a library is linked once those are there that it needs."""
        everything, waiting, there = self.extensions, list(self.extensions), set[str]()
        while waiting:
            self.extensions = [extension for extension in waiting if there.issuperset(needs(extension))]
            waiting = [extension for extension in waiting if extension not in self.extensions]
            for extension in self.extensions:
                if needs(extension):
                    extension.library_dirs.append(os.path.dirname(self.get_ext_fullpath(extension.name)))
            super().build_extensions()
            there.update(extension.name.removeprefix(NATIVE + "lib") for extension in self.extensions)
        self.extensions = everything

    def get_ext_filename(self, name: str) -> str:
        """Libraries for C are no modules of Python, and have their own names."""
        if name.rpartition(".")[2] in LIBRARIES:
            return name.replace(".", os.sep) + ".so"
        return str(super().get_ext_filename(name))

    def translate(self) -> None:
        """Python to C, in as many processes as there are processors; what takes a compiler longest goes first."""
        from Cython.Build import cythonize

        translated = cythonize(
            self.extensions,
            compiler_directives=DIRECTIVES,
            build_dir="build/cython",
            include_path=["src"],
            nthreads=PROCESSES,
            force=self.force or None,  # None leaves the choice to CYTHON_FORCE_REGEN
        )
        for extension, c in zip(self.extensions, translated, strict=True):
            extension.sources, extension.depends = c.sources, c.depends
        self.extensions.sort(key=lambda extension: -Path(extension.sources[0]).stat().st_size)


def compiled_core() -> list[Extension]:
    """The core's extensions: each an ordinary Python source with its C types in the .pxd beside it."""
    return [
        Extension(
            name,
            [f"src/{name.replace('.', '/')}.py"],
            extra_compile_args=optimisation(level),
            optional=MODE != "require",
        )
        for name, level in CORE.items()
    ]


def socketcan_shim() -> list[Extension]:
    """What `canwire run` preloads: plain C without Python, in the shape of an extension so that it is built as one."""
    if not sysconfig.get_platform().startswith("linux"):  # what is built for, which another system may do
        return []
    folder = Path("src/canwire/socketcan/shim")
    return [
        Extension(
            SHIM,
            sorted(str(path) for path in folder.glob("*.c")),
            depends=sorted(str(path) for path in folder.glob("*.h")),
            libraries=["dl", "pthread"],
            extra_compile_args=["-std=gnu11", "-O2", "-g0", "-Wall", "-Wextra", "-fvisibility=hidden"],
            optional=MODE != "require",
        )
    ]


def native_libraries() -> list[Extension]:
    """What programs in C and C++ are linked with: no Python in them either."""
    if not sysconfig.get_platform().startswith("linux"):
        return []
    return [native_library(name) for name in LIBRARIES]


def needs(extension: Extension) -> tuple[str, ...]:
    """Other libraries of ours that have to be there first."""
    return LIBRARIES.get(extension.name.removeprefix(NATIVE), ((), ()))[1]


def native_library(name: str) -> Extension:
    home = Path("src/canwire/native")
    folders, needed = LIBRARIES[name]
    sources = sorted(str(path) for folder in folders for path in (home / folder).glob("*.c*"))
    plus = any(source.endswith(".cpp") for source in sources)
    return Extension(
        NATIVE + name,
        sources,
        depends=sorted(str(path) for path in home.rglob("*.h")),
        include_dirs=[str(home / "core"), str(home / "include")],
        libraries=[*needed, "dl", "pthread"],
        language="c++" if plus else "c",
        extra_compile_args=[
            *(["-std=gnu++17", "-fno-exceptions", "-fno-rtti"] if plus else ["-std=gnu11"]),
            *["-O2", "-g0", "-Wall", "-Wextra", "-fvisibility=hidden"],
        ],
        extra_link_args=[f"-Wl,-soname,{name}.so", "-Wl,-rpath,$ORIGIN", "-Wl,--as-needed"],
        optional=MODE != "require",
    )


def optimisation(level: int) -> list[str]:
    """Its compiler's own choice on Windows, which is also what is built for when mingw-w64 compiles (.ci/windows)."""
    return [] if sysconfig.get_platform().startswith("win") else [f"-O{level}", "-g0", "-fno-strict-aliasing"]


if __name__ == "__main__":  # processes that translate may import this file again
    if MODE not in ("auto", "pure", "require"):
        sys.exit(f"CANWIRE_BUILD={MODE!r}: choose auto, pure or require")
    os.chdir(Path(__file__).parent)
    setup(
        ext_modules=[] if MODE == "pure" else [*compiled_core(), *socketcan_shim(), *native_libraries()],
        cmdclass={"build_ext": BuildCore},
        options={"build_ext": {"parallel": PROCESSES}},
    )
