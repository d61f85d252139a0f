"""The Python blocks of docs/porting-vci.md do what they are meant to.

The line before a block is `<!-- sample: name -->`. Each test runs one or two of them, on a hub in this process and
on one in another process, in fast time; another board of the test sends and receives where a sample needs a second
node.
"""

from __future__ import annotations

import argparse
import asyncio
import importlib
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import Event, vci
from canwire.boards.config.configuration import Config
from canwire.commands import VERBS
from canwire.vci import net4, v3
from tests.hubs import serving

ROOT = Path(__file__).resolve().parent.parent.parent
GUIDE = ROOT / "docs" / "porting-vci.md"
BLOCK = re.compile(r"^(?:<!-- sample: (\S+) -->\n)?```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LONG = 30.0  # seconds after which something that should happen never will

FD, CLASSIC = "HW000001", "HW000002"
CONFIG = """
[[bus]]
name = "can0"
data_bit_rate = 2000000

[[board]]
kind = "usb-to-can-fd"
serial = "HW000001"

[[board]]
kind = "usb-to-can"
serial = "HW000002"
"""
BOTH = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED | vci.CAN_OPMODE_ERRFRAME


def samples() -> dict[str, str]:
    """Named blocks of the guide."""
    return dict(BLOCK.findall(GUIDE.read_text(encoding="utf-8")))


def fenced(page: Path, language: str) -> list[str]:
    """All blocks of a language."""
    pattern = rf"^```{language}\n(.*?)^```$"
    return re.findall(pattern, page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def run(name: str) -> Any:
    """A block's names after it has run."""
    space: dict[str, Any] = {"__name__": name}
    exec(compile(samples()[name], f"<sample {name}>", "exec"), space)
    return argparse.Namespace(**space)


@pytest.fixture(scope="module")
def hub_process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Socket of `canwire serve`."""
    with serving(tmp_path_factory.mktemp("hub"), CONFIG) as (address, _):
        yield address


@pytest.fixture(params=["embedded", "process"])
def hub(request: pytest.FixtureRequest) -> Iterator[canwire.Hub]:
    """The hub that samples find by `vci.initialize()`."""
    if request.param == "process":
        made = canwire.connect(request.getfixturevalue("hub_process"))
    else:
        made = canwire.connect(time="fast", config=Config.parse(CONFIG))
    with made:
        vci.initialize(made)
        yield made


@pytest.fixture(params=["embedded", "process"])
def timed_hub(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[canwire.Hub]:
    """The same where a program's second of silence is the bus's, however busy this machine is."""
    with ExitStack() as closing:
        address = None
        if request.param == "process":
            address = closing.enter_context(serving(tmp_path, CONFIG, time="lockstep")).address
        config = Config.parse(CONFIG) if address is None else None
        time = "lockstep" if address is None else None
        made = closing.enter_context(canwire.connect(address, time=time, config=config, timed=True))
        vci.initialize(made)
        yield made


class Port:
    """A line at 500 kbit/s and a channel on it, through VCI. Without `errors` it hears of no errors on the bus."""

    def __init__(
        self,
        board: str,
        connector: int,
        *,
        extended: bool = False,
        start: bool = True,
        errors: bool = True,
    ) -> None:
        device = vci.query_device_by_hwid(board)
        self.bal = device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
        two = "2" if extended else ""
        self.control = self.bal.open_socket(connector, getattr(vci, f"IID_ICanControl{two}"))
        self.socket = self.bal.open_socket(connector, getattr(vci, f"IID_ICanSocket{two}"))
        self.channel = self.socket.create_channel(False)
        self.channel.initialize(1000, 1000)
        self.channel.activate()
        self.reader, self.writer = self.channel.get_reader(), self.channel.get_writer()
        self.event = Event()
        if start and not extended:
            mode = BOTH if errors else BOTH & ~vci.CAN_OPMODE_ERRFRAME
            self.control.init_line(
                vci.CanInitLine(mode, bt_reg0=vci.CAN_BT0_500KB, bt_reg1=vci.CAN_BT1_500KB)
            )
        if start and extended:
            run("init-line-2").init_line(self.control)
        if start:
            self.control.start_line()

    def await_count(self, count: int) -> None:
        """Wait until so many messages are in the receive FIFO."""
        self.reader.assign_event(self.event)
        self.reader.set_threshold(count)
        while self.reader.get_fill_count() < count:
            assert self.event.wait(LONG), f"{self.reader.get_fill_count()} of {count} messages"

    def data(self, count: int) -> list[Any]:
        """The next `count` data messages; others are dropped."""
        found: list[Any] = []
        while len(found) < count:
            self.await_count(1)
            message = self.reader.get_data_entry()
            if message.msg_info.type == vci.CAN_MSGTYPE_DATA:
                found.append(message)
        return found

    def drain(self) -> None:
        """Forget everything that came up to now."""
        while self.reader.get_fill_count():
            self.reader.get_data_entry(discard=True)

    def send(self, *identifiers: int, data: bytes = b"\x01", **bits: int) -> None:
        for identifier in identifiers:
            self.writer.put_data_entry(vci.CanMsg(msg_id=identifier, data=data, **bits))

    def talk(self) -> None:
        """Send 100h with a counter every 10 ms, for ever."""
        scheduler = self.bal.open_socket(0, vci.IID_ICanScheduler)
        index = scheduler.add_message(
            vci.CanCyclicTxMsg(cycle_time=100, incr_mode=vci.CAN_CTXMSG_INC_16, msg_id=0x100, data=bytes(2))
        )
        scheduler.start_message(index, 0)
        scheduler.resume()


@pytest.fixture
def partner(hub: canwire.Hub) -> Port:
    """The other side: connector 1 of the classic board."""
    return Port(CLASSIC, 0)


@pytest.fixture
def waiting_partner(timed_hub: canwire.Hub) -> Port:
    """What the guide has in the other terminal: a frame that gets through as soon as the program acknowledges it.

    Until then its controller repeats it, and each time is an error: whoever asks for those has a full FIFO.
    """
    made = Port(CLASSIC, 0, errors=False)
    made.send(0x123, data=b"\x11")
    return made


@pytest.fixture
def port(partner: Port) -> Port:
    """Ours, started, and empty."""
    made = Port(FD, 0)
    made.drain()
    return made


def heard(port: Port, partner: Port, identifiers: list[int]) -> list[int]:
    """Which of the identifiers get through to the port; the last message in the row is known to."""
    port.drain()
    partner.send(*identifiers)
    found: list[int] = []
    while not found or found[-1] != identifiers[-1]:
        found += [message.msg_id for message in port.data(1)]
    return found


# the guide itself


def test_every_block_has_a_name_and_a_test() -> None:
    names = [name for name, _ in BLOCK.findall(GUIDE.read_text(encoding="utf-8"))]
    assert all(names)
    assert len(set(names)) == len(names)
    source = Path(__file__).read_text(encoding="utf-8")
    used = set(re.findall(r'\b(?:run|program)\(\s*"([^"]+)"', source))
    assert used == set(samples())


def test_what_is_linked_exists() -> None:
    text = GUIDE.read_text(encoding="utf-8")
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
    for target in re.findall(r"\]\(([^)]+)\)", text):
        path, _, anchor = target.partition("#")
        assert not path or (GUIDE.parent / path).exists()
        assert not anchor or anchor in anchors


@pytest.mark.parametrize("page", [GUIDE, ROOT / "README.md"], ids=lambda page: page.name)
def test_commands_exist(page: Path) -> None:
    lines = [
        line for block in fenced(page, "console") for line in block.splitlines() if line.startswith("$ ")
    ]
    assert lines
    for line in lines:
        command, verb, *words = shlex.split(line.removeprefix("$ "), comments=True)
        assert command == "canwire"
        parser = argparse.ArgumentParser(exit_on_error=False)
        importlib.import_module(VERBS[verb].module).add_arguments(parser)
        parser.parse_args(words)


@pytest.mark.finding("vci F12.1")
def test_the_hub_that_the_guide_shows_is_the_usual_one() -> None:
    config = Config.default()
    [text] = [block for block in fenced(GUIDE, "console") if "canwire hub on" in block]
    assert f"{len(config.bus)} buses, {len(config.board)} boards, real time" in text


def test_the_configuration_is_one() -> None:
    [text] = fenced(GUIDE, "toml")
    config = Config.parse(text)
    assert [bus.name for bus in config.bus] == ["can0", "body", "lin0"]
    assert config.board[0].serial == "HW123456"


# V4


def test_errors(hub: canwire.Hub, capsys: pytest.CaptureFixture[str]) -> None:
    open_control = run("errors").open_control
    bal = Port(FD, 1).bal
    first = open_control(bal)
    assert isinstance(first, vci.CanControl)
    assert open_control(bal) is None
    bal.release()
    with pytest.raises(vci.VciError):
        open_control(bal)
    assert "VCI_E_INVHANDLE (0xE0010007)" in capsys.readouterr().out


@pytest.mark.smoke
@pytest.mark.conforms("X4-05", "X4-06")
@pytest.mark.finding("vci F1")
def test_the_first_program(timed_hub: canwire.Hub, capsys: pytest.CaptureFixture[str]) -> None:
    """As printed, but for the time."""
    run("first")
    [shown] = [text for text in fenced(GUIDE, "text") if "68656c6c6f" in text]
    assert re.sub(r"time=\d+", "time=641", capsys.readouterr().out) == shown


LIN_READERS = {
    "V4, one": lambda: run("lin-get-data-entry"),
    "V4, many": lambda: run("lin-acquire-read"),
    "V3, one": lambda: run("v3-lin-read-message"),
    "V3, many": lambda: run("v3-lin-read-messages"),
}


@pytest.mark.finding("vci F1")
@pytest.mark.parametrize("name", LIN_READERS)
def test_lin(hub: canwire.Hub, name: str) -> None:
    device = vci.query_device_by_hwid(FD)
    bal = device.open_component(vci.CLSID_VCIBAL, vci.IID_IBalObject)
    event, found = Event(), []
    if name.startswith("V3"):
        boards = v3.VciServer.get_device_manager().get_device_list()
        board = next(one for one in boards if one.unique_hardware_id == FD)
        listening = board.open_bus_access_layer().open_socket(2, v3.LinMonitor)
        listening.initialize(100, False)
        listening.activate()
        reader: Any = listening.get_message_reader()
        monitor, _ = run("lin").ask_and_answer(bal)
    else:
        monitor, _ = run("lin").ask_and_answer(bal)
        reader = monitor.get_reader()
    reader.assign_event(event)

    def work(message: Any) -> None:
        raw = getattr(message, "raw", message)
        if raw.msg_info.type == vci.LIN_MSGTYPE_DATA:
            found.append((raw.msg_info.pid & vci.LIN_PIDMASK_ID, raw.data, raw.msg_info.sor))

    sample = LIN_READERS[name]()
    sample.do_messages(reader, work)
    while not found:
        assert event.wait(LONG)
        sample.do_messages(reader, work)
    assert found == [(0x10, b"\x01\x02", 1)]


@pytest.mark.finding("dialects 8")
def test_a_whole_program(timed_hub: canwire.Hub, waiting_partner: Port) -> None:
    timed_hub.run_for(1.0)  # until somebody starts it
    ended = run("life")
    assert ended.info.description == "USB-to-CAN FD (simulated)"
    assert [(message.msg_id, message.data) for message in waiting_partner.data(1)] == [(0x100, b"\x42")]
    kinds = [message.msg_info.type for message in ended.received]
    assert vci.CAN_MSGTYPE_INFO in kinds
    assert kinds[-1] == vci.CAN_MSGTYPE_DATA
    with pytest.raises(vci.VciError, match="was released"):
        ended.reader.get_fill_count()


def test_release_by_with(hub: canwire.Hub, capsys: pytest.CaptureFixture[str]) -> None:
    manager = run("with").manager
    assert capsys.readouterr().out.splitlines() == [
        "HW000001 USB-to-CAN FD (simulated)",
        "HW000002 USB-to-CAN V2 (simulated)",
    ]
    with pytest.raises(vci.VciError):
        manager.add_ref()


@pytest.mark.conforms("X4-06", "X4-07")
def test_find_a_board(hub: canwire.Hub) -> None:
    found = run("find")
    assert found.device.get_device_info().hardware_id == FD
    assert found.can_connectors == [0, 1]


@pytest.mark.conforms("X3-02", "X3-03")
def test_boards_come_and_go(hub: canwire.Hub) -> None:
    with vci.get_device_manager() as manager:
        changes = run("hot-plug").watch(manager, LONG)
        assert next(changes) == [FD, CLASSIC]
        hub.plug("usb-to-can", "HW777777")
        assert next(changes) == [FD, CLASSIC, "HW777777"]
        hub.unplug("HW777777")
        assert next(changes) == [FD, CLASSIC]
        changes.close()


@pytest.mark.conforms("X3-35")
def test_a_board_comes_back(hub: canwire.Hub) -> None:
    read_or_reopen = run("reopen").read_or_reopen
    port = Port(FD, 0)
    port.reader.assign_event(port.event)
    port.drain()
    port.event.wait(0)
    assert read_or_reopen(port.reader, None) == (port.reader, None)
    hub.unplug(FD)
    assert port.event.wait(LONG)
    with pytest.raises(vci.VciNoSuchDevice):
        read_or_reopen(port.reader, None)
    before = hub.board(CLASSIC).id
    hub.plug("usb-to-can-fd", FD)
    device, message = read_or_reopen(port.reader, lambda device: device)
    assert message is None
    assert device.get_device_info().hardware_id == FD
    assert device.get_device_info().vci_object_id.as_int64 > before
    hub.unplug(CLASSIC)
    hub.plug("usb-to-can", CLASSIC)  # as other tests expect them, in order


@pytest.mark.conforms("X4-16", "X4-18")
def test_a_can_fd_line(hub: canwire.Hub) -> None:
    port = Port(FD, 0, extended=True)
    status = port.socket.get_line_status()
    assert status.ex_mode == vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
    assert (status.btp_sdr.bps, status.btp_fdr.bps) == (500_000, 2_000_000)
    classic = Port(CLASSIC, 1, extended=True, start=False)
    with pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_EXTDATA"):
        run("init-line-2").init_line(classic.control)


@pytest.mark.conforms("X4-10")
@pytest.mark.parametrize("sample", [lambda: run("get-data-entry"), lambda: run("acquire-read")])
def test_receiving(port: Port, partner: Port, sample: Callable[[], Any]) -> None:
    partner.send(*range(0x100, 0x110))
    port.await_count(16)
    read: list[Any] = []
    sample().receive_messages(port.reader, read.append)
    assert [message.msg_id for message in read] == list(range(0x100, 0x110))
    assert port.reader.get_fill_count() == 0


@pytest.mark.conforms("X4-10")
def test_two_of_five(port: Port, partner: Port) -> None:
    partner.send(1, 2, 3, 4, 5)
    port.await_count(5)
    two, count = run("release-some").take_two(port.reader)
    assert count == 5
    assert [message.msg_id for message in two] == [1, 2]
    block, count = port.reader.acquire_read()
    assert [message.msg_id for message in block] == [3, 4, 5]


@pytest.mark.parametrize("extended", [False, True], ids=["CANMSG", "CANMSG2"])
def test_records(hub: canwire.Hub, extended: bool) -> None:
    pytest.importorskip("numpy")
    other = Port(FD, 1, extended=True)
    port = Port(FD, 0, extended=extended)
    port.drain()
    for identifier, byte in ((0x100, 7), (0x200, 99), (0x1FF, 9)):
        other.writer.put_data_entry(vci.CanMsg2(msg_id=identifier, data=bytes([byte])))
    port.await_count(3)
    assert run("records").loudest(port.reader) == 9
    assert port.reader.get_fill_count() == 0


@pytest.mark.conforms("X4-30", "X4-31")
def test_types_of_messages(hub: canwire.Hub) -> None:
    describe = run("message-types").describe
    port, partner = Port(FD, 0), Port(CLASSIC, 0)
    partner.send(0x123, data=b"\x11\x22")
    shown: list[str] = []
    while "123 11 22" not in shown:
        port.await_count(1)
        shown.append(describe(port.reader.get_data_entry()))
    assert shown[-3:-1] == ["started", "CAN_STATUS_ 0x0"]
    port.drain()
    over_ns = hub.now_ns() + 100_000
    while hub.now_ns() < over_ns:  # a short within the intermission is an overload condition, and no error
        pass
    hub.short("can0")
    try:
        partner.send(0x123)
        port.await_count(1)
        assert describe(port.reader.get_data_entry()) == "CAN_ERROR_ 1, CAN_STATUS_ 0x0"
    finally:
        hub.short("can0", False)
    over = vci.CanMsg(msg_id=1, type=vci.CAN_MSGTYPE_TIMEOVR)
    assert describe(over) == "time stamps began again, 1 time(s)"


@pytest.mark.conforms("X3-34")
def test_ticks_are_seconds(hub: canwire.Hub) -> None:
    port, partner = Port(FD, 0, extended=True), Port(CLASSIC, 0)
    block, _ = partner.writer.acquire_write()
    block[0], block[1] = vci.CanMsg(msg_id=0x100, data=b"1"), vci.CanMsg(msg_id=0x101, data=b"2")
    partner.writer.release_write(2)  # both at once: back to back on the bus
    first, second = (run("time-stamps").seconds(message, port.socket) for message in port.data(2))
    assert second - first == pytest.approx(56 * 2e-6, abs=8e-6)  # a frame of 1 byte at 500 kbit/s


@pytest.mark.conforms("X4-13")
def test_threshold(port: Port, partner: Port) -> None:
    read: list[int] = []
    set_threshold = port.reader.set_threshold
    port.reader.set_threshold = lambda count: (set_threshold(count), partner.send(*range(25)))

    def receive_messages(reader: Any) -> None:
        while reader.get_fill_count():
            read.append(reader.get_data_entry().msg_id)

    run("threshold").read_by_tens(port.reader, receive_messages)
    assert read == list(range(len(read)))
    assert port.reader.get_fill_count() == 25 - len(read) < 10


def test_several_events(hub: canwire.Hub) -> None:
    first, second = Event(), Event()
    signalled = run("select").signalled
    second.set()
    assert signalled([first, second]) == [second]
    assert not second.is_set()


def test_asyncio(port: Port, partner: Port) -> None:
    async def main() -> Any:
        first = asyncio.create_task(run("asyncio").first_data(port.reader))
        await asyncio.sleep(0)  # it is waiting now
        partner.send(0x123)
        return await asyncio.wait_for(first, LONG)

    assert asyncio.run(main()).msg_id == 0x123


def test_transmit_byte(port: Port, partner: Port) -> None:
    transmit_byte = run("put-data-entry").transmit_byte
    assert transmit_byte(port.writer, 0x123, 0x42)
    [message] = partner.data(1)
    assert (message.msg_id, message.data, message.msg_info.ext) == (0x123, b"\x42", 0)
    port.control.stop_line()
    room = port.writer.get_free_count()
    sent = [transmit_byte(port.writer, 0x123, 0) for _ in range(room + 2)]
    assert not sent[-1]


@pytest.mark.conforms("X4-10", "X4-16")
def test_transmit_byte_without_copying(hub: canwire.Hub) -> None:
    port, partner = Port(FD, 0, extended=True), Port(FD, 1, extended=True)
    assert run("acquire-write").transmit_byte(port.writer, 0x1234567, 0x42)
    [message] = partner.data(1)
    assert (message.msg_id, message.data) == (0x1234567, b"\x42")
    assert (message.msg_info.fdr, message.msg_info.ext) == (1, 1)


def test_many_at_once(hub: canwire.Hub) -> None:
    pytest.importorskip("numpy")
    port, partner = Port(FD, 0, extended=True), Port(FD, 1, extended=True)
    assert run("send-records").send_ramp(port.writer, 0x100, 20) == 20
    found = [(message.msg_id, message.data) for message in partner.data(20)]
    assert found == [(0x100 + k, bytes([k])) for k in range(20)]


@pytest.mark.conforms("X3-24", "X4-26")
def test_bits_of_a_message(port: Port, partner: Port) -> None:
    run("bits").transmit_three(port.writer)
    assert sorted(message.data for message in partner.data(3)) == [b"back", b"first", b"once"]
    [back] = port.data(1)
    assert (back.data, back.msg_info.srr) == (b"back", 1)


@pytest.mark.conforms("X3-25", "X4-28")
def test_delayed(port: Port, partner: Port) -> None:
    run("delayed").transmit_slowly(port.socket, port.writer)
    times = [message.time for message in partner.data(3)]
    assert all(later - earlier >= 10_000 for earlier, later in pairwise(times))


@pytest.mark.conforms("X3-12", "X4-22")
def test_auto_init_line(hub: canwire.Hub) -> None:
    Port(CLASSIC, 0).talk()
    listener = Port(CLASSIC, 1)
    port = Port(FD, 0, start=False)
    assert run("auto-init-line").auto_init_line(port.control)
    status = port.control.get_line_status()
    assert (status.bt_reg0, status.bt_reg1) == (vci.CAN_BT0_500KB, vci.CAN_BT1_500KB)
    assert hub.line_status(hub.board(CLASSIC).id, 1).errors == 0  # nobody disturbed
    assert listener.data(1)[0].msg_id == 0x100


def test_auto_init_line_where_nobody_talks() -> None:
    with canwire.connect(time="virtual", config=Config.default()) as hub:
        vci.initialize(hub)
        assert not run("auto-init-line").auto_init_line(Port(FD, 0, start=False).control)
        assert hub.now_ns() >= 10_000_000_000


@pytest.mark.conforms("X4-22")
def test_detect_both_rates(hub: canwire.Hub) -> None:
    third = hub.plug("usb-to-can-fd", "HW777777")
    try:
        ports = [Port("HW777777", number, extended=True) for number in (0, 1)]
        scheduler = ports[0].bal.open_socket(0, vci.IID_ICanScheduler2)
        index = scheduler.add_message(vci.CanCyclicTxMsg2(cycle_time=100, msg_id=1, edl=1, fdr=1, dlc=8))
        scheduler.start_message(index, 0)
        scheduler.resume()
        port = Port(FD, 0, extended=True, start=False)
        sample = run("auto-init-line-2")
        assert sample.detect(port.control) == sample.PAIRS[1]
    finally:
        hub.unplug(third.hardware_id)


@pytest.mark.conforms("X3-26")
def test_only_100_to_103(port: Port, partner: Port) -> None:
    run("filter").only_100_to_103(port.control)
    partner.send(0x100, data=b"", rtr=1)
    sent = [0x0FF, 0x104, 0x102, 0x101, 0x200, 0x000, 0x100, 0x7FF, 0x103]
    assert heard(port, partner, sent) == [0x102, 0x101, 0x100, 0x103]


@pytest.mark.conforms("X3-27")
def test_listed_only(port: Port, partner: Port) -> None:
    port.control.stop_line()
    run("filter-list").listed_only(port.control)
    port.control.start_line()
    sent = [0x0FF, 0x100, 0x101, 0x102, 0x103, 0x104, 0x201, 0x200]
    assert heard(port, partner, sent) == [0x100, 0x101, 0x103, 0x200]


@pytest.mark.conforms("X4-34")
def test_a_channel_s_own_filter(hub: canwire.Hub, partner: Port) -> None:
    port = Port(FD, 0, extended=True)
    port.channel.deactivate()
    run("filter-channel").all_but(port.channel)
    port.reader = port.channel.get_reader()
    sent = [0x0FF, 0x100, 0x101, 0x102, 0x103, 0x104]
    assert heard(port, partner, sent) == [0x0FF, 0x104]


@pytest.mark.conforms("X4-41")
def test_cyclic(port: Port, partner: Port) -> None:
    sample = run("cyclic")
    scheduler, index = sample.five_times(port.bal)
    assert [message.data for message in partner.data(5)] == [bytes([k, 0]) for k in range(5)]
    assert sample.is_done(scheduler, index)


def program(name: str, address: str, *words: str) -> subprocess.Popen[str]:
    """A sample as a process of its own."""
    environment = {**os.environ, "CANWIRE_HUB": address, "PYTHONUNBUFFERED": "1"}
    command = [sys.executable, "-c", samples()[name], *words]
    return subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
    )


@pytest.mark.conforms("X4-08")
def test_a_fifo_between_two_programs(hub_process: str) -> None:
    with program("fifo-writer", hub_process) as writer:
        assert writer.stdout is not None
        identifier = writer.stdout.readline().strip()
        assert len(identifier) == 16
        with program("fifo-reader", hub_process, identifier) as reader:
            read = reader.communicate(timeout=LONG)[0].splitlines()
        assert (reader.returncode, len(read)) == (0, 254)
        assert (read[0], read[253]) == ("0 0.0", "253 126.5")
        writer.communicate("\n", timeout=LONG)
    assert writer.returncode == 0


# V3


@pytest.mark.finding("dialects 8")
def test_v3_a_whole_program(timed_hub: canwire.Hub, waiting_partner: Port) -> None:
    timed_hub.run_for(1.0)
    ended = run("v3-life")
    assert ended.device.unique_hardware_id == FD
    assert [(message.msg_id, message.data) for message in waiting_partner.data(1)] == [(0x100, b"\x42")]
    kinds = [message.frame_type for message in ended.received]
    assert v3.CanMsgFrameType.INFO in kinds
    assert kinds[-1] == v3.CanMsgFrameType.DATA
    with pytest.raises(v3.ObjectDisposedException):
        ended.channel.activate()


def test_todays_net_interface(hub: canwire.Hub) -> None:
    partner = Port(FD, 1, extended=True)
    device = next(iter(net4.VciServer.instance().device_manager.get_device_list()))
    bal = device.open_bus_access_layer()
    channel = bal.open_socket(0, net4.ICanChannel2)
    channel.initialize(100, 100, 0, net4.CanFilterModes.PASS, False)
    channel.activate()
    kept = run("net4").start_and_send(bal, channel.get_message_writer())
    first, second = partner.data(2)
    assert {first.msg_id, second.msg_id} == {0x100, 0x200}
    [long] = [one for one in (first, second) if one.msg_id == 0x100]
    assert (long.data, long.msg_info.fdr) == (b"\x42" + bytes(63), 1)
    for one in kept:
        one.dispose()


def v3_sockets(connector: int, *kinds: type[Any]) -> list[Any]:
    """Sockets of the FD board by the V3 names."""
    device = next(iter(v3.VciServer.get_device_manager().get_device_list()))
    bal = device.open_bus_access_layer()
    return [bal, *(bal.open_socket(connector, kind) for kind in kinds)]


@pytest.fixture
def v3_ends(partner: Port) -> tuple[Any, Any]:
    """A V3 channel's reader and writer, on a line that runs."""
    _, control, channel = v3_sockets(0, v3.ICanControl, v3.ICanChannel)
    control.init_line(v3.CanOperatingModes.STANDARD, v3.CanBitrate.CIA_500_KBIT)
    channel.initialize(100, 100, False)
    control.start_line()
    channel.activate()
    return channel.get_message_reader(), channel.get_message_writer()


def await_messages(reader: Any, count: int) -> None:
    event = v3.AutoResetEvent(False)
    reader.assign_event(event)
    reader.threshold = count
    while reader.fill_count < count:
        assert event.wait_one(round(LONG * 1000))


@pytest.mark.conforms("X3-01", "X3-03")
def test_v3_devices(hub: canwire.Hub, capsys: pytest.CaptureFixture[str]) -> None:
    ended = run("v3-devices")
    assert capsys.readouterr().out.splitlines() == [
        "HW000001 USB-to-CAN FD (simulated)",
        "CAN",
        "CAN",
        "LIN",
        "HW000002 USB-to-CAN V2 (simulated)",
        "CAN",
        "CAN",
    ]
    hub.plug("usb-to-can", "HW777777")
    assert ended.changed.wait_one(round(LONG * 1000))
    hub.unplug("HW777777")


@pytest.mark.conforms("X3-20")
@pytest.mark.parametrize(
    ("sample", "reads"), [(lambda: run("v3-read-message"), 12), (lambda: run("v3-read-messages"), 10)]
)
def test_v3_reading(v3_ends: tuple[Any, Any], partner: Port, sample: Callable[[], Any], reads: int) -> None:
    reader, _ = v3_ends
    partner.send(*range(0x100, 0x10C))
    await_messages(reader, 12)
    read: list[Any] = []
    sample().do_messages(reader, read.append)
    assert [message.identifier for message in read] == list(range(0x100, 0x10C))[:reads]


@pytest.mark.conforms("X3-20")
def test_v3_sending(v3_ends: tuple[Any, Any], partner: Port) -> None:
    _, writer = v3_ends
    assert run("v3-send-message").send_message(writer, 0x123, 0x42)
    [message] = partner.data(1)
    assert (message.msg_id, message.data) == (0x123, b"\x42")
    assert run("v3-send-messages").send(writer)
    first, second, third = partner.data(3)
    assert (first.msg_id, first.data) == (0x100, b"")
    assert (second.msg_id, second.msg_info.rtr, second.msg_info.dlc) == (0x200, 1, 3)
    assert (third.msg_id, third.data) == (0x300, b"\x01\xaf")


@pytest.mark.conforms("X3-12")
def test_v3_auto_init_line(hub: canwire.Hub) -> None:
    Port(CLASSIC, 0).talk()
    Port(CLASSIC, 1)
    _, control = v3_sockets(0, v3.ICanControl)
    run("v3-auto-init-line").auto_init_line(control)
    assert control.line_status.bitrate == v3.CanBitrate.CIA_500_KBIT
    assert control.line_status.is_error_frames_enabled


@pytest.mark.conforms("X3-26", "X3-27")
def test_v3_filter(port: Port, partner: Port) -> None:
    bal = port.bal
    port.control.release()
    _, control = v3_sockets(0, v3.ICanControl)
    run("v3-filter").only_100_to_103(control)
    assert heard(port, partner, [0x0FF, 0x104, 0x101, 0x102, 0x200, 0x103]) == [0x101, 0x102, 0x103]
    assert bal.get_features().bus_socket_count == 3


@pytest.mark.conforms("X3-31", "X3-33")
def test_v3_cyclic(port: Port, partner: Port) -> None:
    [bal] = v3_sockets(0)
    sample = run("v3-cyclic")
    scheduler, message = sample.five_times(bal)
    assert [one.data for one in partner.data(5)] == [bytes([k, 0]) for k in range(5)]
    assert sample.is_done(scheduler, message)


# sharing


@pytest.mark.conforms("PL-13")
def test_whoever_comes_second_finds_the_line_set_up(hub: canwire.Hub) -> None:
    bring_up = run("join").bring_up
    init = vci.CanInitLine(BOTH, bt_reg0=vci.CAN_BT0_500KB, bt_reg1=vci.CAN_BT1_500KB)
    first, second = Port(FD, 0, start=False), Port(FD, 1, start=False)
    first.control.release()
    control = bring_up(first.bal, init)
    assert control.get_line_status().bt_reg1 == vci.CAN_BT1_500KB
    assert bring_up(second.bal, init) is None


def test_virtual_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # no canwire.toml here
    monkeypatch.delenv("CANWIRE_CONFIG", raising=False)
    with run("virtual-time").hub as hub:
        assert 3_660_000_000_000 <= hub.now_ns() < 3_661_000_000_000
