"""The manual's own CanWrite and CanRead, compiled, beside `canwire candrv write|read`: the same words, byte for byte.

The listings are cut out of the manual's text (10.2, 10.3) and compiled against tests/data/candrv/windows.h. CanRead's
reading of arguments is printed twice over, without its `p++`: it is taken from CanWrite, whose it is but for that.
Compared are stdout, exit codes, log files and what is sent. Ours alone is a line about --hub in the usage.
"""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest

import canwire
from canwire import candrv
from canwire.candrv import CanbusEvent
from canwire.commands import main
from tests import warm
from tests.hubs import LONG_S, serving
from tests.missing import needs_program

ROOT = Path(__file__).resolve().parents[3]
MANUAL = ROOT.parent / "shared" / "seeds" / "000_c4a7ca42d189c1e6.txt"
STUBS = ROOT / "tests" / "data" / "candrv"
CONFIG = '[[bus]]\nname = "can0"\n' + "".join(
    f'[[board]]\nkind = "netdcu"\nserial = "HW00000{number}"\n' for number in (1, 2)
)
REGISTRY = "".join(
    f'[candrv.CID{number}]\nBoard = "HW00000{number}"\nEventQueueSize = 4000\n' for number in (1, 2)
)
HUB_LINE = "  --hub <address>: Hub to use (CANWIRE_HUB)\n"
ARGUMENTS = re.compile(
    r"/\* Parse command line arguments \*/.*?(?=/\* Print usage, if required \*/)", re.DOTALL
)

pytestmark = [
    pytest.mark.skipif(not MANUAL.exists(), reason=f"the manual's text is not at {MANUAL}"),
    needs_program("gcc"),
]
# words that end before anything is sent or received
USAGES = [
    "-h",
    "-?",
    "-help",
    "-d CID2: -h",
    "-h -d",
    "CID1:",
    "-b 500000 x",
    "-d",
    "-b",
    "-f",
    "-d CID1: -b",
    "-x 1",
    "-n 5",
    "--d CID1:",
    "-- x",
    "- x",
    "-D CID1:",
    "-d CID1: -B 1",
    "-d CID9:",
    "-dev CID9: -b 1",
    "-f log -d CID0:",
]
RUNS = [
    "",
    "-d CID1:",
    "-b 500000",
    "-baud 0x7A120 -f log",
    "-b 01720440",
    "-f log -d CID1:",
    "-f none/log",
    "-f .",
]


def listing(program: str) -> str:
    """A program's source in the manual, as far as it is there."""
    text = re.sub(r"<\|[^|]*\|>", "", MANUAL.read_text(encoding="utf-8"))
    start = text.index("#include <windows.h>", text.index(f"/*** File:     {program}.c "))
    source = text[start : text.index("\n} \n", start) + 2]
    return source.replace(" Help = TRUE;", " bHelp = TRUE;")


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """CanWrite and CanRead, compiled, by their verbs."""
    home, made = tmp_path_factory.mktemp("listings"), {}
    write, read = listing("CanWrite"), listing("CanRead")
    [parsing] = ARGUMENTS.findall(write)
    first = read.index("/* Parse command line arguments */")
    read = read[:first] + parsing + read[read.index("/* Print usage, if required */") :]
    for verb, source in (("write", write), ("read", read)):
        path = home / f"{verb}.c"
        path.write_text(source, encoding="utf-8")
        made[verb] = home / verb
        command = ["gcc", "-w", f"-I{STUBS}", str(path), "-o", str(made[verb])]
        subprocess.run(command, check=True, capture_output=True)
    return made


@pytest.fixture(scope="module")
def hub(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    with serving(tmp_path_factory.mktemp("hub"), CONFIG) as (address, _):
        yield address


@pytest.fixture
def home(tmp_path: Path, hub: str, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where both run: `ours` and `theirs`; files with what the listing's device reads and writes."""
    (tmp_path / "registry.toml").write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(tmp_path / "registry.toml"))
    monkeypatch.setenv("CANWIRE_HUB", hub)
    monkeypatch.setenv("CAN_OUT", str(tmp_path / "out"))
    monkeypatch.setenv("CAN_IN", str(tmp_path / "in"))
    (tmp_path / "in").touch()
    for name in ("ours", "theirs"):
        (tmp_path / name).mkdir()
    return tmp_path


@pytest.fixture
def other(home: Path, hub: str) -> Iterator[candrv.Handle]:
    """CID2:, so that somebody acknowledges; CID1: is loaded anew."""
    with ExitStack() as closing:
        connection = closing.enter_context(canwire.connect(hub))
        with suppress(canwire.CanwireError):
            candrv.unload(connection, "CID1:")
        handle = closing.enter_context(candrv.open("CID2:", hub=connection))
        handle.baud_rate = 1_000_000
        handle.accept_all()
        handle.mask = CanbusEvent.RECEIVED
        yield handle


def theirs(program: Path, words: list[str], home: Path) -> tuple[int, str]:
    ended = subprocess.run(
        [str(program), *words], cwd=home / "theirs", capture_output=True, text=True, timeout=LONG_S
    )
    return ended.returncode, ended.stdout.replace("\0", "")  # %c of a word that ends there


@pytest.mark.conforms("FT-01", "FT-02", "FT-03")
@pytest.mark.parametrize("verb", ["write", "read"])
@pytest.mark.parametrize("words", USAGES)
def test_what_goes_nowhere(
    programs: dict[str, Path],
    home: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    verb: str,
    words: str,
) -> None:
    monkeypatch.chdir(home / "ours")
    status = main(["candrv", verb, *words.split()])
    assert (status, capsys.readouterr().out.replace(HUB_LINE, "")) == theirs(
        programs[verb], words.split(), home
    )


@pytest.mark.conforms("FT-01", "FT-02")
@pytest.mark.parametrize("words", RUNS)
def test_can_write(
    programs: dict[str, Path],
    home: Path,
    other: candrv.Handle,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    words: str,
) -> None:
    expected = theirs(programs["write"], words.split(), home)
    if "-b" in words:
        other.baud_rate = 500_000
    monkeypatch.chdir(home / "ours")
    status = main(["candrv", "write", *words.split()])
    assert (status, capsys.readouterr().out) == expected
    came = [other.read_event() for _ in range(1000)]
    sent = "".join(f"{event.identifier:x} 0 8 {'0 ' * 8}".rstrip() + "\n" for event in came)
    assert sent == (home / "out").read_text()
    assert _log(home / "ours") == _log(home / "theirs") == (sent if "-f log" in words else None)


@pytest.mark.conforms("FT-03")
@pytest.mark.parametrize("words", RUNS)
def test_can_read(programs: dict[str, Path], home: Path, other: candrv.Handle, words: str) -> None:
    """What ours shows of three messages, given to theirs as its device's events, comes out alike."""
    with _reading(home / "ours", words) as ours:
        assert ours.stdout is not None
        lines = [ours.stdout.readline()]
        while lines[-1] and not lines[-1].startswith("Start receiving"):
            lines.append(ours.stdout.readline())
        other.baud_rate = 500_000 if "-b" in words else 1_000_000
        other.write("731 0 4 11 22 33 44\n112 1 0\n7 0 8 0 1 2 3 4 5 6 7\n")
        changed = "-b" in words  # the first event then, without a second line
        shown = "".join(ours.stdout.readline() for _ in range(6 + changed))
        ours.send_signal(signal.SIGINT)
        rest, _ = ours.communicate(timeout=LONG_S)
    events = re.findall(r"[^\t].*\n(?:\t.*\n)?", shown)
    assert len(events) == 3 + changed
    (home / "in").write_bytes(b"".join(event.replace("\n\t", "\r\n\t").encode() + b"\0" for event in events))
    status, out = theirs(programs["read"], words.split(), home)
    assert (ours.returncode, "".join(lines) + shown + rest) == (status, out.replace("\r\n", "\n"))
    assert _log(home / "ours") == _log(home / "theirs") == (shown if "-f log" in words else None)


@contextmanager
def _reading(home: Path, words: str) -> Iterator[subprocess.Popen[str]]:
    """`canwire candrv read`, at whose end nothing is left of it."""
    command = [sys.executable, "-m", "canwire", "candrv", "read", *words.split()]
    with warm.Popen(command, cwd=home, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def _log(home: Path) -> str | None:
    path = home / "log"
    return path.read_text() if path.is_file() else None
