"""`canwire acan term`: what CANTERM sends, shows and sets up; on a terminal, and across two processes."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, Frame, InUse, Unplugged, acan
from canwire.commands import main
from canwire.commands.acan.machines import config_of, configured_machine, identifier, set_up
from canwire.commands.acan.term import PATTERN, SEQUENCE, Printable, Terminal, messages
from canwire.commands.acan.words import machine, parsed
from tests import warm
from tests.cases import each
from tests.commands.acan.bench import ONE, TWO, Bench
from tests.commands.acan.double import Wire
from tests.commands.acan.screen import ON_DOUBLE, OpenScreen, environment


def pair(wire: Any, **options: bool) -> tuple[Terminal, Terminal]:
    """Machines 1 and 2 in conversation; the options are machine 2's."""
    terminals = []
    for local, remote, own in ((1, 2, {}), (2, 1, options)):
        driver = wire.driver()
        set_up(driver, local)
        terminals.append(Terminal(driver, local, remote, **own))
        terminals[-1].open()
    return terminals[0], terminals[1]


# words


@pytest.mark.conforms("AT-01")
def test_words_as_ms_dos_wrote_them() -> None:
    words = parsed(["/C:8000", "/r:125", "/i/E", "3", "/l", "0"], "CR", "IEL")
    assert (words.number("C", 16_000), words.number("R", 250)) == (8000, 125)
    assert set("IEL") <= set(words.switches)
    assert words.rest == ("3", "0")
    usual = parsed(["1", "2"], "CR", "IEL")
    assert (usual.number("C", 16_000), usual.number("R", 250), set(usual.switches)) == (16_000, 250, set())


@each("word", ["/X", "/C", "/C:", "/I:1", "/", "/IE", "/:5"])
def test_no_such_switch(word: str) -> None:
    with pytest.raises(BadValue, match=r"there are /C:\.\.\., /R:\.\.\., /I, /E, /L"):
        parsed([word], "CR", "IEL")


def test_numbers_are_numbers() -> None:
    with pytest.raises(BadValue, match="/C:fast: decimal digits"):
        parsed(["/C:fast"], "C").number("C", 1)
    assert parsed(["/P:280/I:5"], "PI").number("P", 0, 16) == 0x280


@pytest.mark.conforms("AT-01")
def test_machines_are_0_to_7() -> None:
    assert [machine(str(number), "local MID") for number in range(8)] == list(range(8))
    for text in ("8", "-1", "", "1.0", "12"):
        with pytest.raises(BadValue, match="remote MID"):
            machine(text, "remote MID")


# addresses


@pytest.mark.conforms("AT-01", "AC-17", "AC-18")
@each("number", range(8))
def test_a_message_names_its_machine(number: int) -> None:
    assert format(identifier(number), "011b") == f"00001001{number:03b}"


@pytest.mark.conforms("AC-18", "AT-02")
@each("local", range(1, 8))
def test_the_controller_lets_in_its_own_and_what_is_for_all(local: int) -> None:
    config = config_of(local)
    passing = {number for number in range(8) if config.accepts(identifier(number))}
    assert passing == {0, local}
    assert config.accepts(0x500 | local)  # other programs of this machine


@pytest.mark.conforms("AC-12", "AT-01")
def test_usual_rates() -> None:
    config = config_of(1)
    assert (config.clock_khz, config.rate_kbps, config.ts1, config.ts2) == (16_000, 250, 11, 5)
    assert dict(config.registers())["BTR0"] & 0x3F == 1


# setting up


@pytest.mark.conforms("AT-01")
def test_a_controller_nobody_has_set_up() -> None:
    driver = Wire().driver()
    assert set_up(driver, 3, 16_000, 125) == (3, "")
    assert driver.config() == config_of(3, 16_000, 125)
    assert driver.done == ["configure", "on"]


@pytest.mark.conforms("AT-03")
def test_without_i_an_initialised_controller_is_left_as_it_is() -> None:
    driver = Wire().driver(config_of(3, 16_000, 125), on_bus=True)
    assert set_up(driver, 3, 16_000, 250) == (3, "")
    assert driver.done == []
    assert driver.config() == config_of(3, 16_000, 125)


@pytest.mark.conforms("AT-03")
def test_what_does_not_fit_is_told() -> None:
    driver = Wire().driver(config_of(3), on_bus=True)
    local, remark = set_up(driver, 2)
    assert local == 2
    assert remark == (
        "the controller was set up before and accepts nothing for machine 2; /I sets it up again"
    )
    deaf = acan.HardConfig(acan.acan_word(0x4A), acan.acan_word(0x7FF), acan.acan_word(1), acan.acan_word(1))
    assert "for all" in set_up(Wire().driver(deaf), 2)[1]


@pytest.mark.conforms("AT-03")
def test_i_sets_it_up_anew() -> None:
    driver = Wire().driver(config_of(3, 16_000, 125), on_bus=True)
    assert set_up(driver, 2, 16_000, 500, force=True) == (2, "")
    assert driver.config() == config_of(2, 16_000, 500)
    assert driver.done == ["configure", "on"]


@pytest.mark.conforms("AT-02")
def test_local_0_is_the_machines_configured_number() -> None:
    driver = Wire().driver(config_of(5), on_bus=True)
    assert set_up(driver, 0) == (5, "")
    assert set_up(driver, 0, force=True) == (5, "")
    assert driver.config() == config_of(5)


@pytest.mark.conforms("AT-02")
@each(
    ("config", "why"),
    [
        (None, "has no number yet"),
        (acan.HardConfig(), "is none of three bits"),
        (acan.HardConfig(machine_mask=7 << 18, broadcast_mask=7 << 18), "is none of three bits"),
        (acan.HardConfig(0x1 << 18, 0xF << 18, 0, 0xF << 18), "is none of three bits"),
    ],
)
def test_local_0_without_a_number(config: acan.HardConfig | None, why: str) -> None:
    with pytest.raises(BadValue, match=f"local MID 0: .*{why}.*; give 1 to 7"):
        configured_machine(config)


@pytest.mark.conforms("AT-11")
@pytest.mark.finding("acan A15.9")
def test_a_spy_does_not_let_it_set_its_filter_up() -> None:
    driver = Wire().driver(config_of(1), on_bus=True)
    driver.holder = "canwire acan spy"
    assert set_up(driver, 1) == (1, "")
    with pytest.raises(
        InUse, match=r"cannot install its own message filter: .*canwire acan spy; start CANSPY last"
    ):
        set_up(driver, 2, force=True)


# conversation


@pytest.mark.smoke
@pytest.mark.conforms("AT-01")
def test_what_is_typed_here_appears_there() -> None:
    wire = Wire()
    one, two = pair(wire)
    assert one.typed(b"hello, machine 2") == b""
    assert two.received() == b"hello, machine 2"
    assert two.typed(b"a") == b""
    assert one.received() == b"a"
    assert [frame.data for frame in wire.frames] == [b"hello, m", b"achine 2", b"a"]
    assert [frame.id for frame in wire.frames] == [0x4A, 0x4A, 0x49]
    assert one.received() == b""


@pytest.mark.conforms("AT-02")
def test_remote_0_is_for_all() -> None:
    wire = Wire()
    one, two = pair(wire)
    driver = wire.driver()
    set_up(driver, 7)
    seven = Terminal(driver, 7, 0)
    seven.open()
    seven.typed(b"all")
    assert (one.received(), two.received(), seven.received()) == (b"all", b"all", b"")
    one.typed(b"two")
    assert (two.received(), seven.received()) == (b"two", b"")


@pytest.mark.conforms("AT-04")
def test_echo() -> None:
    one, two = pair(Wire(), echo=True)
    assert two.typed(b"seen here\x15") == b"seen here" + SEQUENCE
    assert one.received() == b"seen here" + SEQUENCE


@pytest.mark.conforms("AT-04")
def test_loop_sends_every_message_back_as_it_was() -> None:
    wire = Wire()
    one, two = pair(wire, loop=True)
    one.typed(b"0123456789")
    assert two.received() == b"0123456789"
    assert one.received() == b"0123456789"
    assert [(frame.id, frame.data) for frame in wire.frames[2:]] == [(0x49, b"01234567"), (0x49, b"89")]


@pytest.mark.conforms("AT-05")
def test_ctrl_u() -> None:
    wire = Wire()
    one, _ = pair(wire)
    one.typed(b"\x15")
    assert [frame.data for frame in wire.frames] == [b"01234567", b"89ABCDEF"]


@pytest.mark.conforms("AT-05")
def test_ctrl_t() -> None:
    wire = Wire()
    one, two = pair(wire)
    one.typed(b"x\x14y")
    assert [frame.data for frame in wire.frames] == [b"x", *messages(PATTERN), b"y"]
    assert two.received() == b"x" + PATTERN + b"y"


@pytest.mark.conforms("AT-05")
def test_the_pattern() -> None:
    assert len(PATTERN) == 344
    rows = PATTERN.decode("ascii").split("\r\n")
    assert [len(row) for row in rows] == [41] * 8 + [0]
    assert rows[0] == r"|\     /|\     /|\     /|\     /|\     /|"  # as far as the manual's scan can be read
    assert rows[7] == r"|/     \|/     \|/     \|/     \|/     \|"


@given(st.binary(max_size=100))
def test_bytes_go_out_as_they_are(data: bytes) -> None:
    wire = Wire()
    one, two = pair(wire)
    one.send(data)
    assert two.received() == data
    assert all(len(frame.data) == 8 for frame in wire.frames[:-1])


def test_remote_frames_and_other_identifiers_are_nothing_to_show() -> None:
    wire = Wire()
    _, two = pair(wire)
    wire.put(Frame(0x4A, remote=True, dlc=3))
    wire.put(Frame(0x14A, b"no"))
    wire.put(Frame(0x4A, b"yes"))
    assert two.received() == b"yes"


def test_it_is_woken_once_for_what_it_has_not_taken() -> None:
    wire = Wire()
    one, _ = pair(wire)
    driver = wire.driver()
    set_up(driver, 2)
    woken: list[int] = []
    terminal = Terminal(driver, 2, 1, woken=lambda: woken.append(1))
    terminal.open()
    one.typed(b"0123456789")
    assert len(woken) == 1
    assert terminal.received() == b"0123456789"
    one.typed(b"!")
    assert len(woken) == 2


def test_complaints() -> None:
    one, _ = pair(Wire())
    one.driver.happen(acan.Condition.BUSERR, ecc=0xD9)  # type: ignore[attr-defined]
    one.driver.happen(acan.Condition.BUSERR, ecc=0xD9)  # type: ignore[attr-defined]
    assert one.received() == b""
    assert one.complaints == ["bus error at the acknowledge slot, sending: nobody acknowledges"]
    one.driver.full = True  # type: ignore[attr-defined]
    one.typed(b"a")
    assert one.complaints[1].startswith("not sent: b'a': INDU CAN 1: transmit queue full")


def test_after_bus_off_it_is_on_the_bus_again() -> None:
    one, _ = pair(Wire())
    driver: Any = one.driver
    driver.on_bus = False
    driver.happen(acan.Condition.BUSOFF)
    one.received()
    assert driver.on_bus
    assert one.complaints == [
        "bus-off: the error counters are full",
        "on the bus again; what was waiting to be sent is lost",
    ]


def test_closed_it_receives_nothing_and_a_lost_board_is_told() -> None:
    wire = Wire()
    one, two = pair(wire)
    driver: Any = two.driver
    driver.failure = Unplugged("board HW000001 was unplugged")
    with pytest.raises(Unplugged):
        two.check()
    two.close()
    two.close()
    two.check()
    one.typed(b"a")
    assert two.received() == b""


# what a screen takes


@each(
    ("data", "text"),
    [
        (b"a\rb\nc\r\nd", "a\nb\nc\nd"),
        (b"\x1b[2J\x00\x7f", "^[[2J^@^?"),
        ("é€".encode(), "é€"),
        (b"\xff", "�"),
        (b"\t\a\b", "\t\a\b"),
        ("\x9b".encode(), "."),
    ],
)
def test_printable(data: bytes, text: str) -> None:
    assert Printable().text(data) == text


@given(st.binary(), st.integers(1, 8))
def test_printable_in_pieces(data: bytes, size: int) -> None:
    whole, pieces = Printable(), Printable()
    text = "".join([pieces.text(data[at : at + size]) for at in range(0, len(data), size)])
    assert text == whole.text(data)
    assert not re.search("[\x00-\x06\x0b-\x1f\x7f-\x9f]", text)


# the program


@pytest.mark.conforms("AT-01", "AT-05")
def test_on_a_terminal(open_screen: OpenScreen) -> None:
    """Machine 2 sends everything back: it is shown once."""
    screen = open_screen(*ON_DOUBLE, "term", "1", "2")
    screen.wait("canwire: CANTERM: machine 1 to machine 2; Ctrl-C ends")
    screen.type(b"hello\r")
    screen.wait("\nhello\n")
    screen.type(b"\x15")
    screen.wait("\n0123456789ABCDEF\n")
    screen.type(b"\r\x14")
    screen.wait(PATTERN.decode().replace("\r\n", "\n"))
    screen.type(b"\x03")
    assert screen.end() == 0


@pytest.mark.conforms("AT-04")
def test_echo_on_a_terminal(open_screen: OpenScreen) -> None:
    screen = open_screen(*ON_DOUBLE, "term", "/E", "1", "3")  # there is no machine 3
    screen.wait("machine 1 to machine 3; Ctrl-C ends")
    screen.type(b"echo\rof this\x03never")
    assert "\necho\nof this\n" in screen.wait("of this")
    assert screen.end() == 0


def test_without_a_terminal_bytes_are_copied() -> None:
    data = bytes(range(256)) * 3
    command = [sys.executable, *ON_DOUBLE, "term", "1", "2", "-T", "0"]
    done = warm.run(command, env=environment(), input=data, capture_output=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, data)
    assert done.stderr == b"canwire: CANTERM: machine 1 to machine 2\n"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["1"], "two machine numbers are needed: LOCAL REMOTE"),
        (["1", "8"], "remote MID '8': a machine's number is 0 to 7"),
        (["/X", "1", "2"], "/X: there are /C:..., /R:..., /I, /E, /L"),
        (["--", "/R:fast", "1", "2"], "/R:fast: decimal digits"),
        (["1", "2", "--hub", "/nowhere/hub"], "/nowhere/hub"),
    ],
)
def test_mistakes(words: list[str], why: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["acan", "term", *words]) == 2
    told = capsys.readouterr().err
    assert told.startswith("canwire: ")
    assert why in told
    assert told.count("\n") == 1


# on a bus


@pytest.mark.conforms("AT-01", "AT-05", "AT-06")
def test_canterm_and_wct_across_two_processes(bench: Bench, tmp_path: Path) -> None:
    ini = tmp_path / "WCT.INI"
    ini.write_text("[WCT]\nLocal=2\nTarget=1\nEcho=1\n")
    wct = bench.screen("wct", TWO, "--ini", str(ini))
    wct.wait("machine 2 to machine 1, 250 kbit/s, echo")
    term = bench.screen("term", ONE, "1", "2")
    term.wait("CANTERM: machine 1 to machine 2; Ctrl-C ends")
    term.type(b"from term\x15")
    wct.wait("from term0123456789ABCDEF")
    wct.type(b"from wct\x15")
    wct.wait("from wct0123456789ABCDEF")
    term.wait("from wct0123456789ABCDEF")
    wct.type(b"\r\x14")
    term.wait(PATTERN.decode().replace("\r\n", "\n"))
    term.type(b"\x03")
    assert term.end() == 0


@pytest.mark.conforms("AT-02", "AT-03", "AT-04")
def test_numbers_setting_up_and_loop_on_a_bus(bench: Bench) -> None:
    status, _, told = bench.run("term", TWO, "0", "1", "-T", "0")
    assert (status, told) == (2, "canwire: local MID 0: this machine has no number yet; give 1 to 7\n")
    loop = bench.screen("term", TWO, "/L", "/R:125", "2", "1")
    loop.wait("machine 2 to machine 1; Ctrl-C ends")
    term = bench.screen("term", ONE, "/R:125", "1", "0")  # to all
    term.wait("machine 1 to all machines; Ctrl-C ends")
    term.type(b"and back")
    loop.wait("and back")
    term.wait("and back")
    third = bench.screen("term", TWO, "0", "1")
    third.wait("CANTERM: machine 2 to machine 1")
    third.type(b"left as it was: 125 kbit/s")
    term.wait("left as it was: 125 kbit/s")
    forced = bench.screen("term", TWO, "/i", "/r:125", "3", "1")
    forced.wait("CANTERM: machine 3 to machine 1")
    status, _, told = bench.run("term", TWO, "2", "1", "-T", "0")
    assert told.splitlines()[0] == (
        "canwire: the controller was set up before and accepts nothing for machine 2; /I sets it up again"
    )


@pytest.mark.conforms("AC-33")
def test_a_lone_terminal_is_told_that_nobody_acknowledges(bench: Bench) -> None:
    term = bench.screen("term", ONE, "1", "2")
    term.wait("Ctrl-C ends")
    for _ in range(3):
        term.type(b"?")
        term.wait("bus error at the acknowledge slot, sending: nobody acknowledges")
    term.type(b"\x03")
    assert term.end() == 0


@pytest.mark.conforms("AC-05", "AC-06")
def test_installation(bench: Bench, tmp_path: Path) -> None:
    def acan(*words: str) -> tuple[int, str, str]:
        return bench.run("install", "", *words)  # type: ignore[no-any-return]

    assert acan("/P:300", "/I:7*") == (0, "ACAN is installed for HW000105: /P:300 /I:7*\n", "")
    assert acan("/U") == (0, "ACAN is not installed any more\n", "")
    status, _, told = bench.run("term", "", "1", "2", "-T", "0")
    assert status == 2
    assert "the ACAN driver was uninstalled" in told
    ini = tmp_path / "SYSTEM.INI"
    ini.write_bytes(b"; f\xfcr Windows\r\n[ACAN]\r\nBase=280\r\nIrq=5\r\n")
    assert acan("--ini", str(ini)) == (0, "ACAN is installed for HW000104: /P:280 /I:5\n", "")
    assert bench.run("term", "", "1", "2", "-T", "0")[0] == 0
    assert acan("/U")[0] == 0
    status, _, told = acan("/P:100/I:5")
    assert status == 2
    assert "no controller answers at 100h with IRQ 5" in told
    assert acan("/P:280", "/I:5", "--ini", str(ini))[0] == 2


@pytest.mark.conforms("AC-06")
def test_setup(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "ACAN"
    assert main(["acan", "setup", "300", "7", str(folder)]) == 0
    paths = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert all(path.parent == folder and path.exists() for path in paths)
    assert {"START", "STOP"} <= {path.name for path in paths}
    for words in (["300"], ["nonsense", "7"], ["300", "6", str(folder)]):
        assert main(["acan", "setup", *words]) == 2


def test_a_board_by_its_name(bench: Bench) -> None:
    assert bench.run("term", TWO, "/I", "2", "1", "-T", "0")[0] == 0
    status, _, told = bench.run("term", "HW999999", "1", "2", "-T", "0")
    assert status == 2
    assert "HW999999" in told
