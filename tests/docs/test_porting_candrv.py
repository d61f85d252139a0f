"""The Python blocks of docs/porting-candrv.md do what they are meant to.

A block stands behind `<!-- sample: name -->`. Each test runs one or two of them, on a hub in this process, called
directly and by its socket, in fast time; CID2: and up are the other boards on the bus, CID5: and up with filters
aligned otherwise.
"""

from __future__ import annotations

import argparse
import importlib
import os
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import candrv
from canwire.boards.config.configuration import Config
from canwire.candrv import CanbusEvent, win32
from canwire.candrv.constants import (
    GENERIC_READ,
    GENERIC_WRITE,
    INVALID_HANDLE_VALUE,
    OPEN_EXISTING,
    ControlCode,
)
from canwire.candrv.registry.registry import RegistryStore, Settings
from canwire.commands import VERBS
from tests.hubs import served_here

ROOT = Path(__file__).resolve().parent.parent.parent
GUIDE = ROOT / "docs" / "porting-candrv.md"
BLOCK = re.compile(r"^(?:<!-- sample: (\S+) -->\n)?```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LONG_MS = 30_000

BOARDS = 7
CONFIG = '[[bus]]\nname = "can0"\n' + "".join(
    f'\n[[board]]\nkind = "netdcu"\nserial = "HW00000{number}"\n' for number in range(1, BOARDS + 1)
)
ALIGNMENT = {5: "Align = 1", 6: "MaskActive = 1", 7: "Align = 2"}
REGISTRY = "".join(
    f'[candrv.CID{n}]\nBoard = "HW00000{n}"\nEventQueueSize = 2000\n{ALIGNMENT.get(n, "")}\n'
    for n in range(1, BOARDS + 1)
)


def samples() -> dict[str, str]:
    """The guide's blocks by their names."""
    return dict(BLOCK.findall(GUIDE.read_text(encoding="utf-8")))


def fenced(language: str) -> list[str]:
    """All blocks of a language."""
    return re.findall(
        rf"^```{language}\n(.*?)^```$", GUIDE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )


def run(name: str) -> Any:
    """A block's names after it has run."""
    space: dict[str, Any] = {"__name__": name}
    exec(compile(samples()[name], f"<sample {name}>", "exec"), space)
    return argparse.Namespace(**space)


@pytest.fixture(params=["embedded", "socket"])
def hub(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[canwire.Hub]:
    """The hub that samples find, with a registry of CID1: to CID4:."""
    (tmp_path / "registry.toml").write_text(REGISTRY)
    monkeypatch.setenv("CANWIRE_CONFIG", str(tmp_path / "registry.toml"))
    with ExitStack() as closing:
        if request.param == "socket":
            made = canwire.connect(served(tmp_path, closing))
        else:
            made = canwire.connect(time="fast", config=Config.parse(CONFIG))
        closing.enter_context(made)
        win32.use(made)
        closing.callback(win32.use, None)
        yield made


def served(home: Path, closing: ExitStack) -> str:
    """Socket of a hub."""
    return closing.enter_context(served_here(home, CONFIG))


def opened(device: str, *, read: bool = True) -> candrv.Handle:
    """Accepts everything; nothing takes for ever."""
    handle = candrv.open(device, read=read)
    timeouts = handle.timeouts
    timeouts.ReadTotalTimeoutConstant = timeouts.WriteTotalTimeoutConstant = LONG_MS
    handle.timeouts = timeouts
    if handle.readable:
        handle.accept_all()
    return handle


@pytest.fixture
def can(hub: canwire.Hub) -> Iterator[candrv.Handle]:
    """CID1:, which the samples use."""
    with opened("CID1:") as handle:
        yield handle


@pytest.fixture
def other(hub: canwire.Hub) -> Iterator[candrv.Handle]:
    """CID2:, on the same bus."""
    with opened("CID2:") as handle:
        yield handle


def messages(handle: candrv.Handle, count: int) -> list[candrv.Event]:
    """The next so many that were received."""
    found: list[candrv.Event] = []
    while len(found) < count:
        event = handle.read_event()
        if event.event == CanbusEvent.RECEIVED:
            found.append(event)
    return found


def in_thread(call: Callable[[], object]) -> Callable[[], None]:
    """Runs it; call the result to wait for its end."""
    thread = threading.Thread(target=call, daemon=True)
    thread.start()

    def wait() -> None:
        thread.join(LONG_MS / 1000)
        assert not thread.is_alive()

    return wait


# the guide itself


def test_every_block_has_a_name_and_a_test() -> None:
    names = [name for name, _ in BLOCK.findall(GUIDE.read_text(encoding="utf-8"))]
    assert all(names)
    assert len(set(names)) == len(names)
    used = set(re.findall(r'(?:run\(|sample", \[)"([^"]+)"', Path(__file__).read_text(encoding="utf-8")))
    used |= {"first", "can-write-win32", "coded-network"}
    assert used == set(samples())


def test_it_is_short() -> None:
    """Every sample of the manual stands in C and in Python: that takes more than the other guides' 600 lines."""
    assert len(GUIDE.read_text(encoding="utf-8").splitlines()) <= 1000


def test_what_is_linked_exists() -> None:
    text = GUIDE.read_text(encoding="utf-8")
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
    for target in re.findall(r"\]\(([^)]+)\)", text):
        path, _, anchor = target.partition("#")
        assert not path or (GUIDE.parent / path).exists()
        assert not anchor or anchor in anchors


def test_commands_exist() -> None:
    lines = [line for block in fenced("console") for line in block.splitlines() if line.startswith("$ ")]
    assert lines
    for line in lines:
        command, verb, *words = shlex.split(line.removeprefix("$ "), comments=True)
        assert command == "canwire"
        parser = argparse.ArgumentParser(exit_on_error=False)
        importlib.import_module(VERBS[verb].module).add_arguments(parser)
        parser.parse_args(words)


def test_the_configuration_is_one(tmp_path: Path) -> None:
    [text] = fenced("toml")
    (tmp_path / "canwire.toml").write_text(text)
    store = RegistryStore(tmp_path / "canwire.toml")
    assert store.settings("CID1") == Settings(board="HW000001", baudrate=500_000)
    assert store.settings("CID2") == Settings(
        index=2, board="HW000002", baudrate=500_000, acceptance_mask=0xFFFFFFFF
    )
    assert [board.kind for board in Config.load(tmp_path / "canwire.toml").board] == ["netdcu", "netdcu"]


@pytest.mark.finding("candrv B9")
def test_the_first_program_runs_as_printed(tmp_path: Path) -> None:
    """In the directory of its canwire.toml, in a process of its own, without a hub."""
    (tmp_path / "canwire.toml").write_text(fenced("toml")[0])
    (tmp_path / "first.py").write_text(samples()["first"])
    outside = ("CANWIRE_HUB", "CANWIRE_CONFIG")
    environment = {name: value for name, value in os.environ.items() if name not in outside}
    environment |= {"XDG_RUNTIME_DIR": str(tmp_path), "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        [sys.executable, "first.py"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LONG_MS / 1000,
        check=False,
    )
    assert done.stderr == ""
    [shown] = [text for text in fenced("text") if "received" in text]
    assert re.sub(r"0:\d+", "0:2", done.stdout) == shown


def test_every_function_and_code_is_there() -> None:
    text = GUIDE.read_text(encoding="utf-8")
    functions = ("CreateFile", "CloseHandle", "WriteFile", "ReadFile", "SetCommTimeouts", "GetCommTimeouts",
                 "SetCommMask", "GetCommMask", "WaitCommEvent", "DeviceIoControl")  # fmt: skip
    headings = " ".join(re.findall(r"^### (.*)$", text, re.MULTILINE))
    assert all(name in headings for name in functions)
    assert all(f"`{code.name}`" in text for code in ControlCode)
    sections = " ".join(re.findall(r"^\| `[A-Z_`, ]+` \| ([\d., ]+) \|", text, re.MULTILINE))
    assert re.findall(r"8\.\d+", sections) == [f"8.{number}" for number in range(11, 30)]


def test_differences_and_troubles_have_whole_rows() -> None:
    text = GUIDE.read_text(encoding="utf-8")
    for heading in ("## Differences from real boards", "## Troubles"):
        rows = re.findall(r"^\| .*", text.partition(f"{heading}\n")[2].partition("\n## ")[0], re.MULTILINE)
        assert len(rows) > 15
        assert {len(re.findall(r"(?<!\\)\|", row)) for row in rows} == {4}


# CanWrite, CanRead


@pytest.mark.conforms("FT-01")
@pytest.mark.parametrize("sample", ["can-write", "can-write-win32"])
def test_can_write(
    sample: str, hub: canwire.Hub, other: candrv.Handle, capsys: pytest.CaptureFixture[str]
) -> None:
    other.device.change(rate=500_000)
    came: list[candrv.Event] = []
    wait = in_thread(lambda: came.extend(messages(other, 1000)))
    assert run(sample).can_write("CID1:", 500_000) == 0
    wait()
    assert capsys.readouterr().out == "Start sending 1000 messages to CID1:, baudrate=500000 Hz\n"
    assert [(event.identifier, event.data) for event in came] == [(k, bytes(8)) for k in range(1000)]


@pytest.mark.parametrize("sample", ["can-write", "can-write-win32"])
def test_can_write_without_a_device(
    sample: str, hub: canwire.Hub, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(sample).can_write("CID9:") == 1
    assert capsys.readouterr().out == "Can't open device CID9:, error 2\n"


@pytest.mark.conforms("FT-03", "FS-26")
def test_can_read(
    hub: canwire.Hub,
    other: candrv.Handle,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ready, handles = threading.Event(), []
    wait_for_event = candrv.Handle.read_text

    def read_text(handle: candrv.Handle, size: int | None = None) -> bytes:
        handles.append(handle)
        ready.set()
        return wait_for_event(handle, size)

    monkeypatch.setattr(candrv.Handle, "read_text", read_text)
    wait = in_thread(run("can-read").can_read)
    assert ready.wait(LONG_MS / 1000)
    other.write("731 0 4 11 22 33 44\n")
    other.mask = CanbusEvent.TRANSMITTED
    assert other.wait_comm_event(LONG_MS / 1000) == CanbusEvent.TRANSMITTED
    while len(handles) < 2:  # it waits for the second event
        assert ready.wait(LONG_MS / 1000)
    handles[0].close()
    wait()
    out = capsys.readouterr().out
    assert re.fullmatch(r"received\t0:\d+\t00000731\t0\t4\r\n\t11\t22\t33\t44\t0\nRead error (995|6)\n", out)


# function by function


@pytest.mark.conforms("FS-15", "FS-16")
def test_open(hub: canwire.Hub) -> None:
    ended = run("open")
    assert ended.refused[0] == 1450
    assert "all 2 receive channels are taken" in ended.refused[1]
    assert ended.denied == "ERROR_ACCESS_DENIED"


@pytest.mark.conforms("FS-23")
def test_write_file(can: candrv.Handle, other: candrv.Handle) -> None:
    run("write-file").send(can)
    assert [(event.identifier, event.data) for event in messages(other, 2)] == [
        (0x731, b"\x11\x22\x33\x44"),
        (0x123, b"\x11\x22"),
    ]


@pytest.mark.conforms("FS-26")
def test_read_file(can: candrv.Handle, other: candrv.Handle) -> None:
    sample = run("read-file")
    can.mask = CanbusEvent.RECEIVED
    other.write("731 0 4 11 22 33 44\n1 0 0\n2 0 0\n")
    text, event = sample.first_event(can)
    assert re.fullmatch(rb"received\t0:\d+\t00000731\t0\t4\r\n\t11\t22\t33\t44\t0\n", text)
    assert (event.identifier, event.data) == (0x731, b"\x11\x22\x33\x44")
    assert [line.split("\t")[2] for line in sample.lines(can, 2)] == ["00000001", "00000002"]


@pytest.mark.conforms("FS-29")
def test_timeouts(can: candrv.Handle) -> None:
    can.mask = CanbusEvent.RECEIVED
    assert run("timeouts").within_300_ms(can) is None
    assert can.timeouts.ReadTotalTimeoutConstant == 300


@pytest.mark.conforms("FS-33", "FS-36")
def test_mask(can: candrv.Handle, other: candrv.Handle) -> None:
    sample = run("mask")
    can.device.change(rate=500_000)
    other.device.change(rate=500_000)
    sample.no_changes(can)
    other.write("731 0 0\n")
    assert messages(can, 1)[0].lost == 1
    woken: list[int] = []
    wait = in_thread(lambda: woken.append(sample.until_woken(can)))
    while can.mask != CanbusEvent.LEAVING_STANDBY:
        other.timeouts  # noqa: B018 - lets the other thread run
    other.write("732 0 0\n")
    wait()
    assert woken == [CanbusEvent.LEAVING_STANDBY]


ALIGNED = {
    "from_120_to_127": ("CID5:", [0x120, 0x127, 0x123]),
    "the_same_with_align_0": ("CID1:", [0x120, 0x127, 0x123]),
    "with_mask_active": ("CID6:", [0x120, 0x127, 0x123]),
}


@pytest.mark.conforms("FS-37")
@pytest.mark.parametrize("sample", ALIGNED)
def test_filters_of_standard_frames(hub: canwire.Hub, other: candrv.Handle, sample: str) -> None:
    """8.11's first example, with data or without."""
    device, wanted = ALIGNED[sample]
    with opened(device) as can:
        filters = run("filter")
        getattr(filters, sample)(can)
        other.write("".join(f"{number:x} 0 2 11 22\n" for number in (0x11F, 0x120, 0x127, 0x128, 0x123)))
        assert [event.identifier for event in messages(can, 3)] == wanted
        assert filters.current(can) == (can.filter.code, can.filter.mask)


@pytest.mark.conforms("FS-37", "FS-38")
def test_the_manuals_own_mask_takes_any_data(can: candrv.Handle, other: candrv.Handle) -> None:
    can.filter = candrv.CAN_ACCEPTANCE_FILTER(0x24000000, 0x00E00000)
    other.write("120 0 2 11 22\n121 0 0\n122 0 2 0 0\n")
    assert [event.identifier for event in messages(can, 2)] == [0x120, 0x121]


@pytest.mark.conforms("FS-37")
def test_a_filter_of_extended_frames(hub: canwire.Hub) -> None:
    """8.11's second example, with Align=2."""
    with opened("CID7:") as can, opened("CID2:") as sender:
        for handle in (can, sender):
            handle.can_mode = candrv.CanMode.CAN_2_0_B
        run("filter").of_four_groups(can)
        for identifier in (
            0x234500,
            0x4234500,
            0x1234567,
            0x2344FF,
            0x2345FF,
            0x23456AB,
            0x3345FF,
            0x32345AA,
        ):
            sender.write_message(identifier)
        found = [event.identifier for event in messages(can, 4)]
    assert found == [0x234500, 0x1234567, 0x2345FF, 0x32345AA]


@pytest.mark.conforms("FS-26")
def test_messages(can: candrv.Handle, other: candrv.Handle) -> None:
    sample = run("messages")
    for handle in (can, other):
        handle.can_mode = candrv.CanMode.CAN_2_0_B
    can.mask = CanbusEvent.TRANSMITTED | CanbusEvent.RECEIVED
    sample.send_both(can)
    assert [(event.fmt, event.identifier, event.rtr, event.data) for event in messages(other, 2)] == [
        (1, 0x123, 0, b"\x11\x22"),
        (2, 0x12345678, 1, b""),
    ]
    assert [sample.handle_next(can) for _ in range(2)] == ["sent", "sent"]
    other.write_message(0x7, b"\xab\xcd")
    assert sample.handle_next(can) == "7: ab cd"
    can.mask = CanbusEvent.DEVICE_CHANGED
    can.initialise()
    assert sample.handle_next(can) is None


@pytest.mark.conforms("FS-42", "FS-43", "FS-46")
def test_rates(can: candrv.Handle, other: candrv.Handle) -> None:
    sample = run("rates")
    can.mask = CanbusEvent.DEVICE_CHANGED
    rates = sample.rates(can)
    assert (len(rates), rates[6]) == (9, 500_000)
    assert (sample.set_rate(can), sample.is_in_the_table(can)) == (250_000, True)
    assert (sample.set_rate(can, 40_000), sample.is_in_the_table(can)) == (40_000, False)
    assert (sample.set_rate_by_constant(can), can.baud_rate) == (6, 500_000)
    assert [can.read_event().event for _ in range(3)] == [CanbusEvent.DEVICE_CHANGED] * 3
    sample.set_rate_by_constant(other)
    can.mask = CanbusEvent.RECEIVED
    other.write("123 0 0\n")
    assert can.read_event().identifier == 0x123


@pytest.mark.conforms("FS-44", "FS-45")
def test_modes(can: candrv.Handle, other: candrv.Handle) -> None:
    """What a message is sent as that names no format."""
    sample, sent = run("modes"), []
    other.can_mode = candrv.CanMode.CAN_2_0_B
    for setting in (
        None,
        sample.both_kinds_of_frames,
        sample.standard_by_default,
        sample.as_the_mode_has_it,
    ):
        if setting is not None:
            setting(can)
        can.write_message(0x123)
        sent.append(messages(other, 1)[0].fmt)
    assert sent == [1, 2, 1, 2]


@pytest.mark.conforms("FS-59", "FS-60")
def test_init(can: candrv.Handle, other: candrv.Handle, capsys: pytest.CaptureFixture[str]) -> None:
    """It brings the controller back from bus-off; and says why, where somebody holds the line's control."""
    fault = can.device.hub.bus("can0").faults.inject("bit", frame_id=0x123, times=None)
    can.mask = CanbusEvent.BUS_ERROR
    can.write("123 0 0\n")
    assert can.wait_comm_event(LONG_MS / 1000) == CanbusEvent.BUS_ERROR
    fault.cancel()
    assert can.in_configuration_mode()
    run("init").start_again(can)
    assert not can.in_configuration_mode()
    assert capsys.readouterr().out == ""
    can.write("124 0 0\n")
    assert messages(other, 1)[0].identifier == 0x124


@pytest.mark.conforms("FS-51", "FS-55")
def test_commands(can: candrv.Handle, other: candrv.Handle) -> None:
    sample = run("commands")
    other.write("731 0 0\n")
    can.mask = CanbusEvent.RECEIVED
    assert sample.after_an_overrun(can).event == CanbusEvent.RECEIVED
    before = can.time()
    assert sample.all_commands(can) >= before
    assert not can.virtualize


@pytest.mark.conforms("FS-58")
def test_registers(can: candrv.Handle) -> None:
    status, limit = run("registers").look(can)
    assert limit == 96
    assert status & 0x80 == 0  # not bus-off
    assert can.read_register(13) == 64


@pytest.mark.conforms("FS-13")
def test_ioctl(hub: canwire.Hub, other: candrv.Handle) -> None:
    other.baud_rate = 500_000
    number = win32.CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 0, None, OPEN_EXISTING)
    assert run("ioctl").send_at(number, 500_000) == 1
    assert [(event.identifier, event.data) for event in messages(other, 1)] == [(0x123, b"\x11\x22")]
    assert win32.CloseHandle(number)


@pytest.mark.conforms("FS-42", "FS-43", "FS-45", "FS-59", "FS-60")
def test_settings_line_by_line(hub: canwire.Hub) -> None:
    number = win32.CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 0, None, OPEN_EXISTING)
    assert run("ioctl-settings").settings(number) == (True, [500_000, 4, 0], 0)
    assert win32.CloseHandle(number)


@pytest.mark.finding("candrv B8")
def test_with_share_mode_0_each_program_keeps_the_device_to_itself(hub: canwire.Hub) -> None:
    reader = win32.CreateFile("CID1:", GENERIC_READ, 0, None, OPEN_EXISTING)
    refused = win32.CreateFile("CID1:", GENERIC_READ | GENERIC_WRITE, 0, None, OPEN_EXISTING)
    assert (refused, win32.GetLastError()) == (INVALID_HANDLE_VALUE, 32)
    query = win32.CreateFile("CID1:", 0, 0, None, OPEN_EXISTING)
    assert query != INVALID_HANDLE_VALUE
    assert win32.CloseHandle(query)
    assert win32.CloseHandle(reader)


@pytest.mark.finding("candrv B4")
def test_three_channels_to_send_and_two_to_receive(hub: canwire.Hub) -> None:
    with ExitStack() as closing:
        for _ in range(3):
            closing.enter_context(candrv.open("CID1:", read=False))
        for _ in range(2):
            closing.enter_context(candrv.open("CID1:", write=False))
        for wanted in ({"read": False}, {"write": False}):
            with pytest.raises(candrv.CandrvError) as refused:
                candrv.open("CID1:", **wanted)
            assert refused.value.code == candrv.Win32Error.ERROR_NO_SYSTEM_RESOURCES


@pytest.mark.finding("candrv B13")
@pytest.mark.parametrize("rate", [57_600, 115_200])
def test_a_rate_that_the_clock_does_not_make_is_refused(can: candrv.Handle, rate: int) -> None:
    before = can.baud_rate
    with pytest.raises(candrv.CandrvError) as refused:
        can.baud_rate = rate
    assert refused.value.code == candrv.Win32Error.ERROR_INVALID_PARAMETER
    assert can.baud_rate == before


# the network


@pytest.mark.conforms("FS-12")
@pytest.mark.parametrize("sample", ["network", "coded-network"])
def test_the_network(sample: str, hub: canwire.Hub) -> None:
    network = run(sample)
    with ExitStack() as closing:
        sensor, controller, one, two = (
            closing.enter_context(opened(f"CID{number}:")) for number in range(1, 5)
        )
        network.set_up_controller(controller)
        network.set_up_fan(one, 1)
        network.set_up_fan(two, 2)
        for number, degrees in ((1, 85), (2, 79), (2, 90), (1, 60)):
            network.report(sensor, number, degrees)
            network.control(controller)
        assert [network.is_to_turn(one) for _ in range(2)] == [True, False]
        assert [network.is_to_turn(two) for _ in range(2)] == [False, True]
        assert (one.waiting, two.waiting, controller.waiting) == (0, 0, 0)


@pytest.mark.conforms("FS-12")
def test_the_coded_network_s_filters(hub: canwire.Hub) -> None:
    network = run("coded-network")
    with opened("CID1:", read=False) as talker, opened("CID2:") as controller, opened("CID3:") as fan:
        network.set_up_controller(controller)
        network.set_up_fan(fan, 1)
        for identifier in (0b110_01010000, 0b100_00000000, 0b111_11111111):  # any sensor
            talker.write_message(identifier)
        for identifier in (0b011_1111101_0, 0b011_1111101_1, 0b011_1111110_1, 0b001_00101100):
            talker.write_message(identifier)
        talker.write_message(0b101_11111111)
        assert [event.identifier for event in messages(controller, 4)] == [0x650, 0x400, 0x7FF, 0x5FF]
        assert [event.identifier for event in messages(fan, 2)] == [0b011_1111101_0, 0b011_1111101_1]
        assert fan.waiting == 0
