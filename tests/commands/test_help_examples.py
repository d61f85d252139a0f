"""Every example in every verb's --help: the verb knows its words, and it runs unless a reason stands here.

Those of dump, gen, load, view, detect and doctor run in live/test_examples.py, of send and simulate by name in
databases/test_by_name.py, of run in tests/docs/test_socketcan.py.
"""

from __future__ import annotations

import importlib
import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from itertools import islice
from pathlib import Path

import pytest

import canwire
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from canwire.commands import VERBS, main
from canwire.commands.shell.parser import Parser
from tests.cases import each
from tests.commands.conftest import running_lines, served_here
from tests.hubs import LONG_S

EXAMPLES = Path(__file__).parents[2] / "examples"
ELSEWHERE = ("dump", "gen", "load", "view", "detect", "doctor", "simulate", "run")
LASTS = "it lasts until it is told to end: the verb's own tests start and end it"
NOT_RUN = {
    r"play \S+ can0 --loop 3": "as the first one, three times as long",
    r"play drive\.log --time real": "as long as the log is",
    r"record .*": "tests/commands/logs ends recordings",
    r"timing --nodes ecu=.*": "its answer is no, status 1: test_timing.py",
    r"devices --network": "asks other machines",
    r"demo --time real": "lasts for half a minute",
    r"plug slcan .*": "an adapter",
    r"share\b.*": "adapters",
    r"registers .*--follow": LASTS,
    r"recover .*": "a line that is bus-off: test_recover.py",
    r"(isotp|uds) .*": "another side: tests/commands/transport has one",
    r"lin dump .*": LASTS,
    r"lin schedule lin0 10#.*": LASTS,
    r"lin send .*": "a slave that answers: lin/test_verb.py",
    r"lin slave .*": LASTS,
    r"lin (identify|assign|save|request) .*": "a slave that answers: lin/test_requests.py",
    r"native --windows .*": "libraries that .ci/dlls makes: tests/windows",
    r"acan .*": "programs with a screen or a DOS directory: tests/commands/acan",
    r"candrv (?!registry|active|install).*": "programs that need a partner or a port: tests/commands/candrv",
    r"fault .*(inject|unplug|babble|hold|flip --id).*": LASTS,
    r"fault .*--help": "ends argparse: test_usage.py",
    r"campaign .*--runs 10000.*": "minutes of runs: tests/commands/campaign plays fewer",
    r"campaign .*--results \S+parquet": "the same runs: tests/campaigns/test_table.py writes them",
    r"plot .*": "plot/test_plot.py runs them, and looks at the pictures",
    r"campaign .*--repeat 4711 .*": "a run of 10000",
    r"campaign .*--cluster .*": "a cluster: tests/campaigns/test_cluster.py has one",
    r"bridge .*": LASTS,
    r"pace.*": "a hub in lockstep: test_pace.py",
    r"socketcand.*": LASTS,
    r"slcan.*": LASTS,
    r"web.*": LASTS,
    r"serve.*": LASTS,
    r"offer.*": LASTS,
    r"router.*": LASTS,
    r"relay.*": LASTS,
    r"send can0 EngineData .*": "the file stands in the repository: databases/test_by_name.py",
}
WITHOUT_HUB = {"bits", "campaign", "completion", "convert", "db", "decode"}
WITHOUT_HUB |= {"demo", "native", "query", "stats", "timing"}
SYNTAX = r"\[|\]"  # of a line that says which words there are: no words to be parsed


def examples(verb: str) -> list[str]:
    """Without what stands behind two blanks, and without where output goes."""
    text = importlib.import_module(VERBS[verb].module).__doc__ or ""
    return re.findall(rf"^canwire ({verb}\b.*?)(?: >>? \S+)?(?: {{2,}}.*| `.*| or .*)?$", text, re.MULTILINE)


EVERY = [example for verb in VERBS for example in examples(verb)]
RUN = [
    example
    for example in EVERY
    if example.split()[0] not in ELSEWHERE and not any(re.fullmatch(pattern, example) for pattern in NOT_RUN)
]


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with those that the examples name."""
    made = tmp_path_factory.mktemp("files")
    with (EXAMPLES / "car-candump.log").open() as log:
        lines = list(islice(log, 20))
    halves = ("".join(lines[:10]).replace("vcan0", "can0"), "".join(lines[10:]).replace("vcan0", "can1"))
    (made / "drive.log").write_text("".join(halves))
    for name in ("day-0001.log", "day-0002.log"):
        (made / name).write_text(halves[0])
    for name in ("engine.dbc", "car.dbc"):
        shutil.copy(EXAMPLES / "engine.dbc", made / name)
    for name in ("door.ldf", "alive.py"):
        shutil.copy(EXAMPLES / name, made)
    shutil.copy(EXAMPLES / "campaign.py", made / "flips.py")
    for other in ("drive.blf", "trace/"):
        assert main(["convert", str(made / "drive.log"), f"{made}/{other}"]) == 0
    return made


@pytest.fixture
def folder(files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """This test's own, with the files; where a hub would be if there were one."""
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CANWIRE_HUB", str(tmp_path / "hub.sock"))
    return tmp_path


@contextmanager
def busy_hub(home: Path) -> Iterator[None]:
    """The usual boards, can1 as well, and lines on both that acknowledge."""
    buses = tuple(BusConfig(name=name, data_bit_rate=2_000_000) for name in ("can0", "can1"))
    pair = BoardConfig(kind="usb-to-can-fd", serial="HW000009", buses=("can0", "can1"))
    more = BoardConfig(kind="usb-to-can-fd", serial="HW000010", buses=("can1", "can1"))
    boards = (*Config.default().board, pair, more)
    config = Config(bus=(*buses, BusConfig(name="lin0", type="lin")), board=boards)
    with served_here(home, config) as address, canwire.connect(address) as hub, ExitStack() as closing:
        running_lines(hub, closing, "HW000009:0", "HW000009:1")
        yield


@pytest.mark.conforms("N-15")
@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_examples(verb: str) -> None:
    assert examples(verb)


@pytest.mark.conforms("N-15")
@each("example", [one for one in EVERY if not re.search(SYNTAX, one)])
def test_the_words_are_known(example: str, capsys: pytest.CaptureFixture[str]) -> None:
    verb, *words = shlex.split(example)
    parser = Parser(prog=f"canwire {verb}")
    importlib.import_module(VERBS[verb].module).add_arguments(parser)
    if "--help" in words:
        with pytest.raises(SystemExit):
            parser.parse_args(words)
        assert capsys.readouterr().out.startswith("usage: ")
    else:
        assert parser.parse_args(words)


def test_every_reason_is_needed() -> None:
    """One that fits nothing any more is to be taken out."""
    useless = [one for one in NOT_RUN if not any(re.fullmatch(one, example) for example in EVERY)]
    assert useless == []
    assert len(RUN) > 40


@pytest.mark.conforms("N-15")
@pytest.mark.parametrize("example", RUN)
def test_it_runs(example: str, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    sooner = example.replace("--for 2", "--for 0.1").replace("--gap 0.1", "--gap 0.01")
    words = shlex.split(sooner)
    if words[0] == "completion":
        pytest.importorskip("argcomplete")
    if words[0] == "send" or re.match(r"play .*(\bcan0\b|--map)", example):
        words += ["--timeout", str(LONG_S)]  # a busy machine is no mistake of theirs
    if words[0] == "campaign" and "--workers" not in words:
        words += ["--workers", "1"]  # else one for each core, each a program that starts cold
    with nullcontext() if words[0] in WITHOUT_HUB else busy_hub(folder):
        status = main(words)
    said = capfd.readouterr().err
    assert status == 0, said
    assert "Traceback" not in said
