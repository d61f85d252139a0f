"""`canwire fault`: sets a fault, sees it through, says what it did; lists and clears."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable

import pytest

from canwire import BoardInfo, ChannelMode, Frame, Hub, HubChannel, WantedMode, connect
from canwire.commands import main
from canwire.commands.fault.kinds import CAN_KINDS, KINDS, LIN_KINDS
from tests import warm

LONG_S = 30.0
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(hub_address: str, capsys: pytest.CaptureFixture[str]) -> Run:
    """`canwire fault` with these words: its status, stdout and stderr."""

    def fault(*words: str) -> tuple[int, str, str]:
        status = main(["fault", words[0], "--hub", hub_address, *words[1:]])
        shown = capsys.readouterr()
        return status, shown.out, shown.err

    return fault


def on_line(hub: Hub, board: BoardInfo, line: int) -> HubChannel:
    """A channel on a line that runs at the usual rates."""
    channel = hub.open_channel(board.id, line)
    channel.set_up(ChannelMode(64, 64))
    channel.activate()
    with hub.open_control(board.id, line) as control:
        control.initialise(WantedMode().mode(board.lines[line].capabilities))
        control.start()
    return channel


@pytest.mark.conforms("N-08")
def test_it_runs_until_the_fault_is_used_up(hub_address: str) -> None:
    command = [sys.executable, "-m", "canwire", "fault", "can0", "--hub", hub_address]
    with connect(hub_address) as hub:
        board = hub.board("usb-to-can-fd")
        sender, receiver = on_line(hub, board, 0), on_line(hub, board, 1)
        words = ["flip", "--id", "123", "--bit", "20", "--times", "3"]
        process = warm.Popen([*command, *words], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert process.stdout.readline() == "can0: flip bit 20 of standard 123, 3 times: set\n"
        sender.send(Frame(0x123, b"\x11\x22"))
        assert process.stdout.readline() == "can0: struck 3 times; used up\n"
        assert process.wait(LONG_S) == 0
        process.stdout.close()
        frame = receiver.receive(LONG_S)
        assert frame is not None
        assert (frame.id, hub.line_status(board.id, 0).tec) == (0x123, 3 * 8 - 1)
        assert hub.bus("can0").faults.list() == ()


@pytest.mark.conforms("N-08")
def test_ctrl_c_takes_the_fault_back(hub_address: str) -> None:
    command = [sys.executable, "-m", "canwire", "fault", "can0", "--hub", hub_address, "unplug", "HW000001:1"]
    with connect(hub_address) as hub:
        process = warm.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert process.stdout.readline() == "can0: disconnect HW000001:1: set\n"
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "can0: struck once; cancelled\n"
        assert process.wait(LONG_S) == 130
        process.stdout.close()
        assert hub.bus("can0").faults.list() == ()


def test_a_time_ends_it(run: Run) -> None:
    status, out, _ = run("can0", "short", "--for", "0.001")
    assert (status, out) == (0, "can0: short: set\ncan0: struck once; its time was over\n")


def test_json_says_the_same_in_objects(run: Run) -> None:
    _, out, _ = run("can0", "noise", "--rate", "1e-9", "--for", "0.5", "--json")
    begun, over = map(json.loads, out.splitlines())
    assert (begun["event"], begun["kind"], begun["times_left"]) == ("set", "noise", None)
    assert (over["event"], over["struck"], over["over"]) == ("over", 0, "its time was over")


@pytest.mark.smoke
@pytest.mark.conforms("N-08")
def test_what_stays_is_listed_and_cleared(run: Run, hub_address: str) -> None:
    assert run("can0", "cable", "40", "--stay")[:2] == (0, "can0: cable of 40 m: set, and stays\n")
    _, out, _ = run("can0", "--list")
    number, _, rest = out.strip().partition("  ")
    assert number == "1"
    assert rest.startswith("cable of 40 m; struck 1, no end; set by canwire fault (")
    assert rest.endswith("), stays")
    _, out, _ = run("can0", "--list", "--json")
    assert json.loads(out)["text"] == "cable of 40 m"
    with connect(hub_address) as hub:
        hub.bus("can0").faults.noise(1e-9)
        assert run("can0", "--clear")[1] == "can0: 1 fault ended\n"
        assert len(hub.bus("can0").faults.list()) == 1
        assert json.loads(run("can0", "--clear", "--everybody", "--json")[1])["ended"] == 1
        assert run("can0", "--list")[1] == "can0: no faults\n"
        assert run("can0", "--list", "--json")[1] == ""


WORDS = {
    "flip": ("--bit", "ack", "--seen-by", "HW000001:0"),
    "inject": ("crc", "--times", "0"),
    "noise": ("--rate", "0.0001"),
    "hold": ("dominant", "--at", "eof:2", "--id", "18FF0001", "--of", "HW000001:0"),
    "play": ("000--1", "--times", "2"),
    "glitch": ("recessive", "--width", "100", "--start", "20", "--at", "data"),
    "move-edge": ("2", "--at", "frame:13", "--seen-by", "HW000001:0,HW000001:1"),
    "drift": ("HW000001:0", "-200"),
    "rate": ("HW000001:0", "250000"),
    "cable": ("30", "--node-delay", "75"),
    "babble": ("--id", "7FF", "--gap", "1", "--times", "3"),
    "short": (),
    "unplug": ("HW000001:0",),
    "checksum": ("--id", "3"),
    "no-response": (),
    "cut": ("--octets", "2"),
    "stop-bit": ("--octet", "1"),
    "flip-octet": ("--octet", "1", "--bit", "7"),
    "parity": ("--times", "0"),
    "short-break": ("--bits", "9"),
    "sync": ("--value", "0x50"),
}
TEXTS = {
    "flip": "flip ack of any frame, seen by HW000001:0, once",
    "inject": "flip crc of any frame, seen by receivers, every time",
    "hold": "hold dominant for 1 bit at eof 2 of extended 18FF0001, bits of HW000001:0, once",
    "play": "play 000--1 immediately, 2 times",
    "babble": "babble 7FF#, 1000 ms apart, 3 times",
    "cut": "cut 2 of any frame, once",
}


@pytest.mark.conforms("N-08")
@pytest.mark.parametrize("kind", sorted(KINDS))
def test_every_kind_has_its_words(run: Run, hub_address: str, kind: str) -> None:
    bus = "lin0" if kind in LIN_KINDS else "can0"
    with connect(hub_address) as hub:
        channel = on_line(hub, hub.board("usb-to-can-fd"), 0)
        status, out, _ = run(bus, kind, *WORDS[kind], "--for", "0.002")
        channel.close()
    assert status == 0
    first, last = out.splitlines()
    assert first.startswith(f"{bus}: {TEXTS.get(kind, '')}")
    assert first.endswith(": set")
    assert last.startswith(f"{bus}: struck ")


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("can0",), "fault: a KIND, --list or --clear"),
        (("can0", "--list", "--clear"), "fault: a KIND, --list or --clear"),
        (("can0", "--list", "short"), "fault: short without --list and --clear"),
        (("can7", "short"), "no bus 'can7'; there are can0, lin0"),
        (("can0", "flip", "--bit", "20", "--id", "12x"), "--id 12x: hex digits"),
        (("can0", "flip", "--bit", "nowhere"), "bit 'nowhere'"),
        (("can0", "hold", "dominant", "--id", "123"), "--id and --of say where --at is"),
        (("can0", "hold", "dominant", "--at", "eof:x"), "--at eof:x"),
        (("can0", "move-edge", "2"), "--at frame:BIT says which edge"),
        (("can0", "unplug", "HW9:0"), "no line 'HW9:0' on can0; there are HW000001:0"),
        (("can0", "checksum"), "can0 is a CAN bus; its faults are flip, "),
        (("lin0", "flip", "--bit", "2"), "lin0 is a LIN bus; its faults are checksum, "),
        (("lin0", "checksum", "--id", "zz"), "--id zz"),
        (("can0", "short", "--for", "-1"), "lasting -1.0: seconds, more than 0"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(run: Run, words: tuple[str, ...], text: str) -> None:
    status, out, err = run(*words)
    assert (status, out) == (2, "")
    assert err.startswith("canwire: ")
    assert text in err
    assert err.count("\n") == 1


def test_every_kind_is_one_of_can_or_lin() -> None:
    assert set(KINDS) == {*CAN_KINDS, *LIN_KINDS, "short", "unplug"} == set(WORDS)
