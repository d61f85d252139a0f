"""`canwire send` and `canwire simulate` by the names of a network's description."""

from __future__ import annotations

import operator
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import canwire
from canwire import BadValue, ChannelMode, Database, Frame, HubChannel, WantedMode, load_database
from canwire.commands import main
from canwire.commands import send as send_module
from canwire.commands.can_line import open_sender
from canwire.commands.databases import plugins, simulate
from tests import warm
from tests.cases import each

pytest.importorskip("cantools")
ROOT = Path(__file__).resolve().parents[3]
ENGINE = str(ROOT / "examples" / "engine.dbc")
LONG_S = 30


@pytest.fixture(scope="module")
def engine() -> Database:
    return load_database(ENGINE)


@pytest.fixture
def heard(hub_address: str) -> Iterator[HubChannel]:
    """A program that acknowledges and listens."""
    with canwire.connect(hub_address) as hub:
        place = canwire.find_lines(hub, "can0")[0]
        channel = hub.open_channel(place.board.id, place.line)
        channel.set_up(ChannelMode(receive=4096, transmit=0))
        canwire.start_line(hub, place, WantedMode().mode(place.info.capabilities)).close()
        channel.activate()
        yield channel


def examples_of(text: str | None, verb: str) -> list[str]:
    """The command lines in a verb's help, without what is said beside them."""
    assert text is not None
    lines = re.findall(rf"^canwire ({verb} .*?)(?:  .*)?$", text, re.MULTILINE)
    assert lines
    return [line for line in lines if "--db" in line]


@pytest.mark.conforms("N-58")
def test_a_plug_in_counts_what_is_sent_and_checks_what_was_heard(
    hub_address: str, heard: HubChannel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From round to round, and from message to message in it."""
    plugin = ("--plugin", "examples.alive:alive")
    words = ["EngineData", "123#11", "EngineData", "EngineSpeed=1500", "-n", "9", "--db", ENGINE, *plugin]
    assert main(["send", "can0", *words, "--hub", hub_address, "--timeout", str(LONG_S)]) == 0
    frames = [frame for _ in range(27) if (frame := heard.receive(LONG_S)) is not None]
    engine = [frame for frame in frames if frame.id == 0x100]
    alive = load_database(ENGINE)
    counters = [found["Alive"] for frame in engine if (found := alive.decode(frame)) is not None]
    assert counters == [number % 16 for number in range(18)]
    log = tmp_path / "heard.log"
    lines = [f"({number}.0) can0 {canwire.format_frame(frame)}\n" for number, frame in enumerate(frames)]
    log.write_text("".join(lines))
    check = ["decode", str(log), "--db", ENGINE, "--check", *plugin]
    capsys.readouterr()
    assert main(check) == 0
    assert capsys.readouterr() == ("", "canwire: 18 messages, 0 with a wrong counter or checksum\n")
    log.write_text("".join(lines[:3] + lines[6:]))
    assert main(check) == 1
    shown = capsys.readouterr()
    assert shown.out.endswith(": counter 4, not 2\n")
    assert "16 messages, 1 with a wrong counter" in shown.err
    assert main(["send", "can0", "123#11", *plugin]) == 2
    assert "it finishes messages of --db" in capsys.readouterr().err
    assert main([*check[:4], *plugin]) == 2
    assert "it belongs to --check" in capsys.readouterr().err


@pytest.mark.conforms("PF-16")
def test_a_message_by_name(hub_address: str, heard: HubChannel, engine: Database) -> None:
    words = ["EngineData", "EngineSpeed=1500", "Ready=yes", "123#11", "GearboxStatus", "OilPressure=3.5"]
    assert main(["send", "can0", *words, "--db", ENGINE, "--hub", hub_address]) == 0
    frames = [heard.receive(LONG_S) for _ in range(3)]
    assert frames[1] == Frame(0x123, b"\x11")
    first, last = engine.decode(frames[0] or Frame(0)), engine.decode(frames[2] or Frame(0))
    assert (
        str(first)
        == "EngineData(EngineSpeed: 1500 rpm, Temperature: 20 degC, Ready: yes, Alive: 0, Check: 0)"
    )
    assert str(last) == "GearboxStatus(Page: 1, Torque: 0 Nm, OilPressure: 3.5 bar)"


@each(
    ("words", "told"),
    [
        (
            "EngineData EngineSpeed=17000 --db {db}",
            "EngineData.EngineSpeed: 17000 is out of range: 0 to 16000 rpm",
        ),
        (
            "EngineData Ready=maybe --db {db}",
            "EngineData.Ready: no value 'maybe'; 0 to 3, no, yes, unknown is possible",
        ),
        ("EngineData Redy=1 --db {db}", "EngineData.Redy: no such signal; did you mean Ready?"),
        ("EngineDta --db {db}", "no message 'EngineDta'; did you mean EngineData?"),
        ("EngineData Ready=1 Ready=0 --db {db}", "EngineData: Ready is given twice"),
        ("EngineData Ready= --db {db}", "'Ready=': Signal=value is needed"),
        ("Ready=1 --db {db}", "'Ready=1': there is no message in front of it"),
        ("123#11 Ready=1 --db {db}", "'Ready=1': there is no message in front of it"),
        ("EngineData --db none.dbc", "none.dbc: No such file"),
        ("EngineData", "for a message by its name give --db FILE"),
    ],
)
def test_what_cannot_be_sent(capsys: pytest.CaptureFixture[str], words: str, told: str) -> None:
    assert main(["send", "can0", *words.format(db=ENGINE).split()]) == 2
    shown = capsys.readouterr().err
    assert told in shown
    assert shown.count("\n") == 1


@pytest.mark.smoke
@pytest.mark.conforms("PF-15")
def test_a_node_is_simulated(
    hub_address: str, heard: HubChannel, engine: Database, capsys: pytest.CaptureFixture[str]
) -> None:
    words = "simulate Engine can0 --duration 0.1 --set EngineSpeed=1500 --set EngineData.Ready=yes"
    assert main([*words.split(), "--db", ENGINE, "--hub", hub_address]) == 0
    shown = capsys.readouterr().err
    counts = re.search(
        r"EngineData (\d+), EEC1 (\d+); (\d+) sent, (\d+) delivered, (\d+) cycles missed", shown
    )
    assert counts is not None
    data, others, sent, delivered, _ = map(int, counts.groups())
    assert data + others == sent == delivered
    got = [engine.decode(frame) for frame in heard.receive_many(4096)]
    named = [message for message in got if message is not None and message.name == "EngineData"]
    assert len(named) == data
    assert {(message["EngineSpeed"], message["Ready"]) for message in named} == {(1500, "yes")}


@pytest.mark.conforms("PF-15")
def test_a_plug_in_of_the_current_directory(
    hub_address: str,
    heard: HubChannel,
    engine: Database,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "counting.py").write_text("def alive(m):\n    m.signals['Check'] = m.count % 256\n")
    (tmp_path / "one.dbc").write_text(Path(ENGINE).read_text().replace("2364540158 20;", "2364540158 0;"))
    words = "simulate Engine can0 --duration 0.05 --db one.dbc --plugin counting:alive"
    assert main([*words.split(), "--hub", hub_address]) == 0
    checks = [message["Check"] for frame in heard.receive_many(4096) if (message := engine.decode(frame))]
    assert checks == list(range(len(checks)))
    assert checks


def test_a_plug_in_of_an_installed_package(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("halves", "operator:truediv", plugins.GROUP)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [point] if group == plugins.GROUP else [])
    assert plugins.find_plugin("halves") is operator.truediv
    with pytest.raises(BadValue, match=r"there are halves$"):
        plugins.find_plugin("halfs")


@each(
    ("words", "told"),
    [
        ("Engine can0", "simulate needs a description of the network: --db FILE"),
        ("Engin can0 --db {db}", "no node 'Engin'; did you mean Engine?"),
        ("Tester can0 --db {db}", "Tester has no message with a cycle time (messages: TorqueRequest)"),
        ("Engine can0 --db {db} --set Ready", "'Ready': Signal=value is needed"),
        (
            "Engine can0 --db {db} --set Redy=1",
            "Engine sends no signal 'Redy' in cycles; did you mean Ready?",
        ),
        ("Engine can0 --db {db} --set EngineSpeed=-1", "-1 is out of range: 0 to 16000 rpm"),
        ("Engine can0 --db {db} --duration -1", "--duration -1.0: 0 or more"),
        ("Engine can0 --db {db} --plugin nowhere:alive", "--plugin nowhere:alive: No module named 'nowhere'"),
        ("Engine can0 --db {db} --plugin shlex:nothing", "--plugin shlex:nothing: shlex has no 'nothing'"),
        ("Engine can0 --db {db} --plugin os:sep", "--plugin os:sep: '/' cannot be called"),
        (
            "Engine can0 --db {db} --plugin alive",
            "--plugin alive: module:function, or an installed plug-in's name",
        ),
    ],
)
def test_what_cannot_be_simulated(capsys: pytest.CaptureFixture[str], words: str, told: str) -> None:
    assert main(["simulate", *words.format(db=ENGINE).split()]) == 2
    assert told in capsys.readouterr().err


def test_nobody_there_to_acknowledge(hub_address: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", "Engine", "can0", "--duration", "0.05", "--timeout", "0.05", "--db", ENGINE]
    assert main([*words, "--hub", hub_address]) == 1
    assert "frames not delivered: nobody acknowledges" in capsys.readouterr().err


def test_an_ecu_sends_on_where_nobody_listens(capsys: pytest.CaptureFixture[str]) -> None:
    """A minute without anybody: what finds no room is left out, and counted; the simulation does not end."""
    simulation = canwire.load_database(ENGINE).simulated("Engine")
    with canwire.connect(time="virtual") as hub, ExitStack() as closing:
        place, channel = open_sender(hub, "can0", WantedMode(), 16, closing)
        running = simulate.Running(hub, channel, simulation, send_module.Sending(hub, place, channel, 0.1))
        began_ns = hub.now_ns()
        running.run(60.0)
        assert hub.now_ns() - began_ns >= 60_000_000_000
        assert capsys.readouterr().err.count("the bus takes no frames: nobody acknowledges") == 1
        assert re.search(
            r"; 1[78] sent, 0 delivered, \d{3,} left out while the bus took none", running.summary()
        )
        assert running.sending.result() == 1


def test_counts_after_ctrl_c(hub_address: str, heard: HubChannel) -> None:
    command = [
        sys.executable,
        "-m",
        "canwire",
        "simulate",
        "Engine",
        "can0",
        "--db",
        ENGINE,
        "--hub",
        hub_address,
    ]
    with warm.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert heard.receive(LONG_S) is not None
        process.send_signal(signal.SIGINT)
        _, shown = process.communicate(timeout=LONG_S)
    assert process.returncode == 130
    assert re.search(r"Engine: EngineData \d+, EEC1 \d+; \d+ sent, \d+ delivered", shown)


@pytest.mark.usefixtures("heard")
@pytest.mark.parametrize(
    "line", examples_of(send_module.__doc__, "send") + examples_of(simulate.__doc__, "simulate")[1:]
)
def test_examples_of_the_help(hub_address: str, monkeypatch: pytest.MonkeyPatch, line: str) -> None:
    """The first of `simulate` lasts until Ctrl-C, which a test above sends."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert main([*shlex.split(line), "--hub", hub_address]) == 0
