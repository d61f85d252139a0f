"""Ctrl-C at any moment from the first import of a verb on: no traceback, no import that hangs, nothing left behind."""

from __future__ import annotations

import enum
import importlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from canwire.commands.shell import outside_imports
from canwire.commands.shell.outside_imports import signals_outside_imports
from canwire.commands.shell.parser import Help, Parser
from canwire.hub.protocol import messages
from canwire.values import frozen

pytestmark = pytest.mark.finding("faults 10")

MAIN = """
import sys
from canwire.__main__ import main
try:
    print("begins", flush=True)
    sys.exit(main())
except KeyboardInterrupt:  # by a signal before its first line
    sys.exit(130)
"""
AT_STEP = """
import atexit, os, signal, sys
from canwire.__main__ import main
steps, last = 0, int(sys.argv.pop(1))

def step(frame, event, argument):
    global steps
    steps += 1
    if steps == last:
        sys.setprofile(None)
        os.kill(os.getpid(), signal.SIGINT)

atexit.register(lambda: print(steps, file=sys.stderr))
sys.setprofile(step)
sys.exit(main())
"""
ENDED = {130, -signal.SIGINT}
POINTS = 6
TAKEN_OVER = (
    100  # steps after which Ctrl-C is the command's; before it is the interpreter's, as in any program
)


def at_step(step: int, words: list[str]) -> tuple[int, str]:
    """A command that gets SIGINT at this step of the interpreter: its status, and what it said."""
    ended = subprocess.run(
        [sys.executable, "-c", AT_STEP, str(step), *words], capture_output=True, text=True, timeout=60
    )
    return ended.returncode, ended.stderr


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
@pytest.mark.parametrize("words", ["devices", "bits 123#11"])
def test_ctrl_c_at_any_step(hub_address: str, words: str) -> None:
    own = [*words.split(), *(["--hub", hub_address] if words == "devices" else [])]
    status, said = at_step(-1, own)
    assert status == 0
    steps = int(said)
    interrupted = 0
    for point in range(POINTS):
        step = TAKEN_OVER + steps * point // (POINTS + 1)
        status, said = at_step(step, own)
        if status == 0:  # waits for the hub took fewer steps this time
            assert int(said) < step
            continue
        interrupted += 1
        assert status in ENDED, said
        assert "Traceback" not in said
    assert interrupted


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
@pytest.mark.parametrize(
    ("words", "also"),
    [("serve --socket {folder}/hub.sock", 0), ("slcan --pty {folder}/tty --hub {hub}", 0),
     ("dump can0 --hub {hub}", 130)],
    ids=["serve", "slcan", "dump"],
)  # fmt: skip
def test_ctrl_c_after_any_time(hub_address: str, tmp_path: Path, words: str, also: int) -> None:
    """`also`: the status once it is at work. Which moments these are differs, what comes of it does not."""
    folder = tmp_path / "own"
    folder.mkdir()
    own = words.format(folder=folder, hub=hub_address).split()
    for moment in range(POINTS):
        with subprocess.Popen(
            [sys.executable, "-c", MAIN, *own],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as running:  # fmt: skip
            assert running.stdout is not None
            assert running.stdout.readline() == "begins\n"
            time.sleep(moment * 0.07)  # moments of its start, one after the other
            running.send_signal(signal.SIGINT)
            try:
                _, said = running.communicate(timeout=60)
            finally:
                running.kill()
        assert running.returncode in ENDED | {also}, said
        assert "Traceback" not in said
        assert [name for name in os.listdir(folder) if not name.endswith(".lock")] == []


AT_THE_CHANGE = """
import os, signal, sys
from canwire.__main__ import main

def change(number, handler):
    if handler is signal.SIG_DFL:
        os.kill(os.getpid(), signal.SIGINT)
    return changed(number, handler)

changed, signal.signal = signal.signal, change
sys.exit(main())
"""


@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_ctrl_c_as_the_system_takes_it_over() -> None:
    """Python dropped it: `canwire serve` said "Signal 2 ignored due to race condition", and ran on."""
    ended = subprocess.run([sys.executable, "-c", AT_THE_CHANGE, "devices"], capture_output=True, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr) == (-signal.SIGINT, b"", b"")


def machinery(text: str) -> dict[str, Callable[[], object]]:
    """Functions as the import system's own: frozen code of that name."""
    found: dict[str, Callable[[], object]] = {}
    exec(compile(text, "<frozen importlib._bootstrap>", "exec"), {"os": os, "signal": signal}, found)
    return found


LOCK = """
def take(done):
    done.append("taken")
    os.kill(os.getpid(), signal.SIGINT)
    for number in range(3):
        done.append(number)
    done.append("given back")
"""


@pytest.mark.usefixtures("ctrl_c")
def test_the_import_systems_own_code_is_never_interrupted() -> None:
    done: list[object] = []
    take = machinery(LOCK)["take"]

    def work() -> None:
        take(done)  # type: ignore[call-arg]
        done.append(len(done))

    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(work)
    assert done == ["taken", 0, 1, 2, "given back"]


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A module that gets SIGINT while it is being loaded, and then counts on."""
    monkeypatch.syspath_prepend(tmp_path)
    name = f"interrupted_{tmp_path.name}"
    (tmp_path / f"{name}.py").write_text(
        "import os, signal\n"
        "def count():\n"
        "    return 1\n"
        "os.kill(os.getpid(), signal.SIGINT)\n"
        "value = sum(count() for _ in range(9))\n"
    )
    return name


@pytest.mark.usefixtures("ctrl_c")
def test_an_import_is_finished_first(module: str) -> None:
    reached: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(lambda: reached.append(importlib.import_module(module).__name__))
    assert sys.modules.pop(module).value == 9
    assert reached == []  # and not a line later


@pytest.mark.usefixtures("ctrl_c")
def test_one_that_takes_long_is_not(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outside_imports, "PATIENCE_S", 0.0)
    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(lambda: importlib.import_module(module))
    assert module not in sys.modules


def test_outside_of_imports_it_is_handled_at_once() -> None:
    heard: list[int] = []
    before = signal.signal(signal.SIGTERM, lambda number, _: heard.append(number))
    try:
        assert signals_outside_imports(lambda: os.kill(os.getpid(), signal.SIGTERM) or list(heard)) == [
            signal.SIGTERM
        ]
    finally:
        signal.signal(signal.SIGTERM, before)


def test_handlers_are_as_before() -> None:
    before = signal.getsignal(signal.SIGINT)
    assert signals_outside_imports(lambda: signal.getsignal(signal.SIGINT)) is not before
    assert signal.getsignal(signal.SIGINT) is before


class _Mode:
    """What a request has as a field."""

    size: int = 1


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_a_class_that_msgspec_asks_for_its_fields_is_finished_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """msgspec takes Ctrl-C there for "it has no fields": `acan wct` ended with "Encoding ... is unsupported", 2."""
    twins, reached = frozen._twins, list[bytes]()

    def interrupted(*given: Any, **named: Any) -> Any:
        os.kill(os.getpid(), signal.SIGINT)
        return twins(*given, **named)

    monkeypatch.setattr(frozen, "_twins", interrupted)
    made: Any = frozen.dataclass  # type checkers take it for the standard library's
    mode = made(frozen=True, slots=True)(_Mode)()
    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(lambda: reached.append(msgspec.msgpack.encode(mode)))
    assert reached == []
    assert msgspec.msgpack.encode(mode) == b"\x81\xa4size\x01"


class _AskedAt(enum.EnumMeta):
    def __getattr__(cls, name: str) -> Any:
        if name == "__msgspec_cache__":
            os.kill(os.getpid(), signal.SIGINT)
        raise AttributeError(name)


class _Colour(enum.Enum, metaclass=_AskedAt):
    RED = 1


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_a_message_is_encoded_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """msgspec forgot Ctrl-C where it asks an enumeration for what it may lack: `canwire dump` continued."""
    decoder, encoded = messages._requests_of, list[bytes]()

    def made(kind: type) -> Any:
        msgspec.msgpack.Decoder(_Colour)
        return decoder(kind)

    monkeypatch.setattr(messages, "_requests_of", made)
    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(lambda: encoded.append(messages.encode_request(1, messages.Hello(1, 2, "a"))))
    assert encoded == []


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_the_words_are_read_first() -> None:
    """argparse gives its arguments other attributes meanwhile, and `canwire dump` ended with an AttributeError, 1."""
    reached: list[Any] = []
    parser = Parser(prog="verb")
    parser.add_argument("lines", nargs="*")
    parser.formatter_class = lambda prog: os.kill(os.getpid(), signal.SIGINT) or Help(prog)  # type: ignore[assignment, func-returns-value, return-value]
    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(lambda: reached.append(parser.parse_args(["can0"])))
    assert reached == []
    parser.formatter_class = Help
    assert parser.parse_args(["can0"]).lines == ["can0"]


class Taken:
    """Is interrupted while it is being taken apart."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.skipif(os.name == "nt", reason="os.kill ends a process there")
def test_a_signal_that_the_interpreter_would_forget_is_raised_once_more() -> None:
    def work() -> None:
        taken = Taken()
        del taken
        while True:
            time.monotonic()

    with pytest.raises(KeyboardInterrupt):
        signals_outside_imports(work)
    assert sys.getprofile() is None
