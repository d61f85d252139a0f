"""docs/socketcan.md's terminals, and the examples of `canwire help run`."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.hubs import LONG_S
from tests.socketcan.bench import Bench, need, on_a_hub_of_its_own

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = (ROOT / "docs" / "socketcan.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\$ (.*)$", PAGE, re.MULTILINE)
PROGRAMS = dict(re.findall(r"<!-- program: (\S+) -->\n```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    yield from on_a_hub_of_its_own(tmp_path)


@pytest.mark.conforms("PL-12", "N-21")
def test_the_page_s_terminals(bench: Bench) -> None:
    serve, dump, generate, write, *others = COMMANDS
    assert others[2:4] + others[6:] == [
        "canwire run tshark -i can0",
        "canwire run tcpdump -i can0 -w can0.pcap",  # socketcan/test_packets.py
        "gcc -static -o my-dump my-dump.c",
        "canwire run ./my-dump",  # socketcan/test_supervised.py
    ]
    assert serve == "canwire serve"
    seen = bench.listening(*dump.split()[2:])
    bench.run(*generate.split()[2:])
    assert seen.stdout is not None
    lines = [seen.stdout.readline().split() for _ in range(3)]
    name = write.split()[1]
    (bench.home / name).write_text(PROGRAMS[name])
    environment = {**os.environ, "CANWIRE_HUB": bench.address}
    subprocess.run([sys.executable, name], cwd=bench.home, env=environment, check=True, timeout=LONG_S)
    lines.append(seen.stdout.readline().split())
    assert [line[1:] for line in lines] == [["can0", "100#4711"]] * 3 + [["can0", "7C1#564349"]]
    times = [float(line[0].strip("()")) for line in lines]
    assert times == sorted(times)


@pytest.mark.conforms("N-49", "N-50")
def test_its_terminals_of_links_and_j1939(bench: Bench) -> None:
    need("ip")
    need("testj1939")
    set_up, show, receive, send = (command.split()[2:] for command in (*COMMANDS[4:6], *COMMANDS[8:10]))
    bench.run(*set_up)
    assert "bitrate 250000" in bench.run(*show)
    receiver = bench.listening("stdbuf", "-oL", *receive)
    bench.run(*send)
    assert receiver.stdout is not None
    assert receiver.stdout.readline().startswith("80 ")


def examples() -> list[str]:
    from canwire.commands.socketcan import run

    assert run.__doc__ is not None
    return re.findall(r"^canwire run (.*?)(?:  .*)?$", run.__doc__, re.MULTILINE)


@pytest.mark.conforms("N-21")
@pytest.mark.parametrize("example", examples())
def test_the_help_s_examples(bench: Bench, example: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(bench.home)
    (bench.home / "test.sh").write_text("#!/bin/sh\ncansend vcan0 123#\n")
    (bench.home / "test.sh").chmod(0o755)
    words = example.split()
    options = words[: words.index("--")] if "--" in words else []
    words = words[len(options) + bool(options) :]
    need("cansend")
    if words[0] in ("candump", "cangen"):
        bench.listening(*words, options=tuple(options))
    else:
        bench.run(*words, options=tuple(options))
