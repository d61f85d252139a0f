"""How quick programs in C++ and C# are on a hub: frames, one way, calls, the start; beside Python and a socket.

python benchmarks/native.py                    needs g++, and mcs and mono for C#; some thirty seconds

Two processes and a FIFO of the hub's between them (VciCreateFifo, elements of 80 bytes as CANMSG2), in C++ and in
Python, and the same through a Unix seqpacket pair; a reader in C# with a writer in C++, and with one in C#. The
figures are of one run on one machine: their relations count.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from canwire.native import dotnet, include_directory, library_directory

PROGRAM = Path(__file__).parent / "native.cpp"
PYTHON = Path(__file__).parent / "native_python.py"
SHARP = Path(__file__).parent / "native.cs"
WHAT = ("call", "batches", "single", "one-way", "socket")


def build(home: Path) -> Path:
    made, lib = home / "native", library_directory()
    subprocess.run(
        ["g++", "-O2", f"-I{include_directory()}", str(PROGRAM), "-o", str(made), f"-L{lib}", f"-Wl,-rpath,{lib}",
         "-lvciapi", "-lcanwire"],
        check=True,
    )  # fmt: skip
    return made


def sharp(home: Path, program: Path, settings: dict[str, str]) -> None:
    """C#'s reader, with a writer in C++ (blocks, one by one) and with C#'s own."""
    made, assemblies = home / "sharp.exe", dotnet.assembly_directory()
    references = [f"-r:{assemblies}/{name}" for name in dotnet.NAMES]
    subprocess.run(["mcs", "-optimize", f"-out:{made}", *references, str(SHARP)], check=True)
    settings = {**settings, "MONO_PATH": assemblies, "LD_LIBRARY_PATH": library_directory()}
    for how, count, name in (
        ("blocks", 3_000_000, "batches"),
        ("single", 1_000_000, "single"),
        ("blocks", 1_000_000, "send"),
    ):
        reader = subprocess.Popen(
            ["mono", str(made), how, str(count), name], env=settings, stdout=subprocess.PIPE, text=True
        )
        assert reader.stdout is not None
        number = reader.stdout.readline().strip()
        writer = ["mono", str(made), "send"] if name == "send" else [str(program), "write"]
        subprocess.run([*writer, number, str(count)], env=settings, check=True)
        print(reader.communicate()[0], end="", flush=True)


def starts(program: Path, settings: dict[str, str]) -> None:
    """With a helper of its own, then with one that the run before has left warm; beside Python's own start."""
    for _ in range(3):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", "pass"], check=True)
        print(f"Python start    {(time.perf_counter() - begun) * 1e3:6.0f} ms for `pass`", flush=True)
        for stays in ("0", "10"):
            print("cold  " if stays == "0" else "warm  ", end="", flush=True)
            subprocess.run(
                [str(program), "start"], env={**settings, "CANWIRE_HELPER_STAYS": stays}, check=True
            )


def main() -> None:
    with tempfile.TemporaryDirectory() as directory:
        home = Path(directory)
        program, address = build(home), str(home / "hub.sock")
        hub = subprocess.Popen(
            [sys.executable, "-m", "canwire", "serve", "--socket", address], stdout=subprocess.PIPE, text=True
        )
        try:
            assert hub.stdout is not None
            assert "canwire hub on" in hub.stdout.readline()
            settings = {**os.environ, "CANWIRE_HUB": address, "CANWIRE_PYTHON": sys.executable}
            starts(program, settings)
            for what in WHAT:
                subprocess.run([str(program), what], env=settings, check=True)
            for what in ("batches", "single", "one-way"):
                subprocess.run([sys.executable, str(PYTHON), what], env=settings, check=True)
            if shutil.which("mcs") and shutil.which("mono"):
                sharp(home, program, settings)
        finally:
            hub.terminate()
            hub.wait()


if __name__ == "__main__":
    main()
