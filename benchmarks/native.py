"""How quick programs in C++ are on a hub: frames through FIFOs, one way, calls, the start; beside Python and a socket.

python benchmarks/native.py                    needs g++; some twenty seconds

Two processes and a FIFO of the hub's between them (VciCreateFifo, elements of 80 bytes as CANMSG2), in C++ and in
Python, and the same through a Unix seqpacket pair. The figures are of one run on one machine: their relations count.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from canwire.native import include_directory, library_directory

PROGRAM = Path(__file__).parent / "native.cpp"
PYTHON = Path(__file__).parent / "native_python.py"
WHAT = ("start", "call", "batches", "single", "one-way", "socket")


def build(home: Path) -> Path:
    made, lib = home / "native", library_directory()
    subprocess.run(
        ["g++", "-O2", f"-I{include_directory()}", str(PROGRAM), "-o", str(made), f"-L{lib}", f"-Wl,-rpath,{lib}",
         "-lvciapi", "-lcanwire"],
        check=True,
    )  # fmt: skip
    return made


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
            for what in WHAT:
                subprocess.run([str(program), what], env=settings, check=True)
            for what in ("batches", "single", "one-way"):
                subprocess.run([sys.executable, str(PYTHON), what], env=settings, check=True)
        finally:
            hub.terminate()
            hub.wait()


if __name__ == "__main__":
    main()
