"""Draws the README's pictures of shared boards from what programs print.

python docs/shared_picture.py > docs/shared.svg                    a hub and three commands
python docs/shared_picture.py five > docs/five-programs.svg        the five programs of five-programs.md
python docs/shared_picture.py socketcan > docs/socketcan.svg       socketcan.md's terminals
python docs/shared_picture.py native > docs/native.svg             programs in C++ and C#, candump and pytest
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from html import escape
from pathlib import Path

import canwire

LINE, LEFT, TOP, WIDTH = 19, 16, 30, 1000
COLOURS = (
    ("$ ", "#7fd962"),
    ("# ", "#6e7681"),
    ("HW", "#59c2ff"),
    ("  can0", "#ffb454"),
    ("  HW", "#ffb454"),
    ("(", "#ffb454"),
)
SEND = ["send", "can0", "123#1122", "18FF1234##1AABBCC", "100#R"]


def command(*words: str) -> list[str]:
    return [sys.executable, "-m", "canwire", *words]


def story() -> list[str]:
    """Three terminals, one after the other."""
    with tempfile.TemporaryDirectory() as home:
        socket = str(Path(home) / "canwire.sock")
        os.environ["CANWIRE_HUB"] = socket
        with subprocess.Popen(
            command("serve", "--socket", socket), stdout=subprocess.PIPE, text=True, cwd=home
        ) as hub:
            assert hub.stdout is not None
            introduction = hub.stdout.readline().rstrip().replace(home, "/run/user/1000")
            dump = subprocess.Popen(
                command("dump", "can0"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
            )
            assert dump.stdout is not None
            assert dump.stderr is not None
            listening = dump.stderr.readline().rstrip()
            subprocess.run(command(*SEND), check=True)
            shown = [dump.stdout.readline().rstrip() for _ in SEND[2:]]
            devices = subprocess.run(command("devices"), capture_output=True, text=True, check=True)
            dump.terminate()
            dump.communicate()
            hub.terminate()
    board = devices.stdout.splitlines()[:5]
    return [
        "# terminal 1", "$ canwire serve", introduction, "",
        "# terminal 2", "$ canwire dump can0", listening, *shown, "",
        "# terminal 3", f"$ canwire {' '.join(SEND)}", "$ canwire devices", *board,
    ]  # fmt: skip


def five() -> list[str]:
    """The programs of the page, and what each of them heard of the others."""
    page = (Path(__file__).parent / "five-programs.md").read_text(encoding="utf-8")
    programs = re.findall(
        r"<!-- program: (\S+) \w+ -->\n```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL
    )
    serve, go = re.findall(r"^\$ canwire (.*)$", page, re.MULTILINE)
    with tempfile.TemporaryDirectory() as home:
        os.environ["CANWIRE_HUB"] = socket = str(Path(home) / "canwire.sock")
        running = [started(home, *command(*serve.split(), "--socket", socket))]
        lines = [
            "# six terminals",
            f"$ canwire {serve}",
            read(running[0], 2)[0].replace(home, "/run/user/1000"),
            "",
        ]
        running += [started(home, sys.executable, "-c", text) for _, text in programs]
        for process in running[1:]:
            read(process, 1)
        subprocess.run(command(*go.split()), check=True)
        for (name, _), process in zip(programs, running[1:], strict=True):
            heard = "   ".join(f"{line:10}" for line in read(process, 4))
            lines += [f"$ python on_{name.replace('-', '_')}.py", f"  {heard}".rstrip()]
        for process in running:
            process.kill()
            process.communicate()
    return [*lines, "", f"$ canwire {go}"]


def socketcan() -> list[str]:
    """candump and cangen, and a program for VCI on the same bus."""
    page = (Path(__file__).parent / "socketcan.md").read_text(encoding="utf-8")
    serve, dump, generate, write = re.findall(r"^\$ (.*)$", page, re.MULTILINE)
    _, text = re.findall(r"<!-- program: (\S+) -->\n```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[0]
    with tempfile.TemporaryDirectory() as home:
        os.environ["CANWIRE_HUB"] = socket = str(Path(home) / "canwire.sock")
        hub = started(home, *command("serve", "--socket", socket))
        introduction = read(hub, 1)[0].replace(home, "/run/user/1000")
        seen = started(home, *command(*dump.split()[1:]))
        with canwire.connect(socket, name="picture") as shared:
            while not any(place.status(shared).channels for place in canwire.every_line(shared, "CAN")):
                time.sleep(0.05)
        subprocess.run(command(*generate.split()[1:]), check=True)
        subprocess.run([sys.executable, "-c", text], check=True)
        shown = read(seen, 4)
        for process in (seen, hub):
            process.kill()
            process.communicate()
    return [
        "# terminal 1", f"$ {serve}", introduction, "",
        "# terminal 2", f"$ {dump}", *shown, "",
        "# terminal 3", f"$ {generate}", f"$ {write}",
    ]  # fmt: skip


TEST = """\
import subprocess, can

def test_greeting():
    with can.Bus(interface="canwire", channel="HW000002:0") as bus:
        subprocess.run("./first", check=True)
        assert bus.recv(10).data == b"\\xca\\xfe"
"""


def native() -> list[str]:
    """The first programs of native.md and native-dotnet.md, candump, and a test of the one in C++."""
    pages, examples = Path(__file__).parent, Path(__file__).parents[1] / "examples" / "native"
    lines = [line for page in ("native.md", "native-dotnet.md") for line in console(pages / page)]
    cpp, cs, mono = (
        next(line for line in lines if part in line).replace("$out/", "").replace("examples/native/", "")
        for part in ("first.cpp", "First.cs", "mono $out")
    )
    serve, dump, first = "canwire serve", "canwire run candump -n 3 HW000002_0", "./first"
    show, test = "cat test_first.py", "pytest -q test_first.py"
    with tempfile.TemporaryDirectory() as home:
        for source in ("first.cpp", "First.cs"):
            shutil.copy(examples / source, home)
        (Path(home) / "test_first.py").write_text(TEST, encoding="utf-8")
        os.environ["CANWIRE_HUB"] = socket = str(Path(home) / "canwire.sock")
        with ExitStack() as running:
            hub = running.enter_context(ended(started(home, *serve.split(), "--socket", socket)))
            introduction = read(hub, 1)[0].replace(home, "/run/user/1000")
            for line in (cpp, cs):
                printed(home, line)
            seen = running.enter_context(ended(started(home, *dump.split())))
            with canwire.connect(socket, name="picture") as shared:
                (place,) = canwire.find_lines(shared, "HW000002:0")
                while not place.status(shared).channels:
                    time.sleep(0.05)
            said = [printed(home, line) for line in (first, mono, show, test)]
            shown = read(seen, 3)
    return [
        "# terminal 1", f"$ {serve}", introduction, "",
        "# terminal 2", f"$ {dump}", *shown, "",
        "# terminal 3", f"$ {cpp} && {first}", *said[0], f"$ {cs}", f"$ {mono}", *said[1], f"$ {show}", *said[2],
        f"$ {test}", *(re.sub(r" in [0-9.]+s", "", text) for text in said[3]),
    ]  # fmt: skip


@contextmanager
def ended(process: subprocess.Popen[str]) -> Iterator[subprocess.Popen[str]]:
    """Nothing of it is left afterwards, whatever happens."""
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def console(page: Path) -> list[str]:
    """The commands of a page."""
    return re.findall(r"^\$ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)


def printed(home: str, line: str) -> list[str]:
    """What a shell prints for this line."""
    done = subprocess.run(line, shell=True, check=True, cwd=home, stdout=subprocess.PIPE, text=True)
    return done.stdout.splitlines()


STORIES = {"five": five, "socketcan": socketcan, "native": native}


def started(home: str, *words: str) -> subprocess.Popen[str]:
    return subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=home)


def read(process: subprocess.Popen[str], count: int) -> list[str]:
    assert process.stdout is not None
    return [process.stdout.readline().rstrip() for _ in range(count)]


def colour(line: str) -> str:
    return next((shade for start, shade in COLOURS if line.startswith(start)), "#c9d1d9")


def picture(lines: list[str]) -> str:
    rows = "".join(
        f'<text x="{LEFT}" y="{TOP + k * LINE}" fill="{colour(line)}" xml:space="preserve">{escape(line)}</text>\n'
        for k, line in enumerate(lines)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{TOP + len(lines) * LINE}" '
        f'font-family="monospace" font-size="14"><rect width="100%" height="100%" rx="8" fill="#0d1117"/>\n'
        f"{rows}</svg>\n"
    )


if __name__ == "__main__":
    sys.stdout.write(picture(STORIES.get("".join(sys.argv[1:]), story)()))
