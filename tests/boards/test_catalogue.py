"""Board kinds by name, boards made after them, and controllers on and off the copper."""

from __future__ import annotations

import re
from importlib.metadata import EntryPoint, EntryPoints
from uuid import UUID

import pytest

from canwire import BadValue, BitTiming, CanwireError, Frame, LinFrame, LinMode, NoSuchBoard, Unsupported
from canwire.boards import board as board_module
from canwire.boards import catalogue, figures
from canwire.boards.board import (
    Board,
    BoardKind,
    BoardLine,
    BoardLinLine,
    Connector,
    checked_bus_name,
    checked_hardware_id,
)
from canwire.boards.can.channel import Channel
from canwire.boards.description import NO_CAN
from canwire.boards.isa import IsaBus
from canwire.boards.lin.description import USB_TO_CAN_FD_LIN
from canwire.boards.lin.modes import LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bus import LinBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline
from tests.cases import each

CLASS = "661DC760-AFA5-4D55-86F5-FABC63600A54"
TOY = BoardKind("toy", CLASS, "Toy", (Connector("CAN", figures.USB_TO_CAN, "can0"),))
SETTINGS = LineSettings(BitTiming.for_bit_rate(500_000), BitTiming.for_bit_rate(2_000_000))


class Copper:
    """A timeline, two CAN buses and a LIN bus."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.can = {name: CanBus(self.timeline, name) for name in ("can0", "can1")}
        self.lin0 = LinBus(self.timeline, "lin0")
        self.buses: dict[str, CanBus | LinBus] = {**self.can, "lin0": self.lin0}
        self.machine = catalogue.Machine(self.timeline, self.buses, IsaBus())

    def plugged(self, name: str, hardware_id: str, *buses: str) -> Board:
        return catalogue.build(catalogue.kind(name), 7, hardware_id, buses, self.machine)


def test_a_can_connector_on_no_bus_is_a_can_line(copper: Copper) -> None:
    board = copper.plugged("usb-to-can", "HW000001", "can0", "")
    assert [type(line) for line in board.lines] == [BoardLine, BoardLine]


@pytest.fixture
def copper() -> Copper:
    return Copper()


@pytest.fixture
def plug_ins(monkeypatch: pytest.MonkeyPatch) -> list[EntryPoint]:
    """What other packages bring, as far as the catalogue can tell."""
    brought: list[EntryPoint] = []
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda group: EntryPoints(brought).select(group=group)
    )
    return brought


def can_lines(board: Board) -> list[BoardLine]:
    return [line for line in board.lines if isinstance(line, BoardLine)]


def lin_line(board: Board) -> BoardLinLine:
    [line] = [line for line in board.lines if isinstance(line, BoardLinLine)]
    return line


def started(board: Board, line: int) -> Channel:
    slot = can_lines(board)[line].line
    channel = slot.open(Channel(64, 64))
    assert slot.driver is not None
    slot.driver.configure(SETTINGS)
    slot.driver.start(slot.timeline.now_ns, integrated=True)
    return channel


@pytest.mark.conforms("X3-01")
@pytest.mark.parametrize(
    ("name", "device_class", "description", "lin"),
    [
        (
            "usb-to-can-fd",
            "B9AAAF39-B9B9-4850-9402-7D8250C7B88F",
            "USB-to-CAN FD (simulated)",
            [("LIN-1", "LIN", "lin0")],
        ),
        ("usb-to-can", "2219F6A0-732A-4750-B66F-0AE731FB40E1", "USB-to-CAN V2 (simulated)", []),
    ],
)
def test_a_board_describes_itself(
    copper: Copper, name: str, device_class: str, description: str, lin: list[tuple[str, str, str]]
) -> None:
    """Device classes: reference/vci.md section 6."""
    info = copper.plugged(name, "HW000042").info
    assert (info.id, info.kind, info.hardware_id) == (7, name, "HW000042")
    assert UUID(info.device_class) == UUID(device_class)
    assert (info.description, info.manufacturer) == (description, "canwire (simulated)")
    assert [(line.name, line.bus_type, line.bus) for line in info.lines] == [
        ("CAN-1", "CAN", "can0"),
        ("CAN-2", "CAN", "can0"),
        *lin,
    ]
    versions = (info.driver_version, info.hardware_version, info.firmware_version)
    assert [len(version) for version in versions] == [4, 4, 2]


@pytest.mark.conforms("X3-01")
def test_lines_tell_what_they_can() -> None:
    kinds = [catalogue.kind(name) for name in ("usb-to-can-fd", "usb-to-can")]
    fd, classic = (kind.line_infos(kind.usual_buses) for kind in kinds)
    assert [line.capabilities for line in fd] == [*[figures.USB_TO_CAN_FD] * 2, NO_CAN]
    assert [line.lin for line in fd] == [None, None, USB_TO_CAN_FD_LIN]
    assert [line.capabilities for line in classic] == [figures.USB_TO_CAN] * 2


def test_lines_are_counted_for_each_kind_of_bus() -> None:
    can, lin = Connector("CAN", figures.USB_TO_CAN, "can0"), Connector("LIN", USB_TO_CAN_FD_LIN, "lin0")
    mixed = BoardKind("mixed", CLASS, "Mixed", (can, can, lin, lin))
    assert [(line.name, line.bus) for line in mixed.line_infos(("can0", "can1", "lin0", ""))] == [
        ("CAN-1", "can0"),
        ("CAN-2", "can1"),
        ("LIN-1", "lin0"),
        ("LIN-2", ""),
    ]


@each(
    ("named", "there", "buses"),
    [
        ((), {"can0", "lin0"}, ("can0", "can0", "lin0")),
        ((), {"can0"}, ("can0", "can0", "")),
        (("can1", "can2"), {"lin0"}, ("can1", "can2", "lin0")),
        (("can1", "can2", "lin7"), set(), ("can1", "can2", "lin7")),
        (("can1", "can2", ""), {"lin0"}, ("can1", "can2", "")),
    ],
)
def test_a_lin_connector_may_be_left_out(
    named: tuple[str, ...], there: set[str], buses: tuple[str, ...]
) -> None:
    assert catalogue.kind("usb-to-can-fd").bus_names(named, there) == buses


def test_lines_go_where_they_are_told(copper: Copper) -> None:
    board = copper.plugged("usb-to-can", "HW1", "can1", "can0")
    assert [line.info.bus for line in board.lines] == ["can1", "can0"]
    assert [line.bus for line in can_lines(board)] == [copper.buses["can1"], copper.buses["can0"]]
    assert [line.line.controller.bus for line in board.lines] == [line.bus for line in can_lines(board)]
    assert [line.line.name for line in board.lines] == ["HW1:0", "HW1:1"]
    assert tuple(line.info for line in board.lines) == board.info.lines


def test_boards_on_one_bus_hear_each_other(copper: Copper) -> None:
    one, other = copper.plugged("usb-to-can-fd", "HW1"), copper.plugged("usb-to-can", "HW2")
    sender, receiver = started(one, 0), started(other, 1)
    can_lines(one)[0].line.send(sender, Frame(0x123, b"\x11"))
    copper.timeline.run_until_idle(10**9)
    assert receiver.receive.take_frame() == Frame(0x123, b"\x11")


def test_a_pulled_board_is_off_the_copper(copper: Copper) -> None:
    one, other = copper.plugged("usb-to-can-fd", "HW1"), copper.plugged("usb-to-can-fd", "HW2")
    sender, receiver = started(one, 0), started(other, 0)
    can_lines(one)[0].line.send(sender, Frame(0x123, bytes(8)))
    copper.timeline.run_until(100_000)  # in the middle of the frame
    catalogue.pull(one, copper.machine)
    catalogue.pull(one, copper.machine)
    copper.timeline.run_until_idle(10**9)
    assert receiver.receive.take_frame() is None
    assert can_lines(other)[0].line.controller.errors == 1  # the others see the frame break off
    assert [line.line.controller.bus for line in one.lines] == [None] * 3
    assert [line.line.controller.running for line in one.lines] == [False] * 3
    assert [node.bus for node in copper.can["can0"].nodes] == [copper.can["can0"]] * 2
    assert copper.lin0.nodes == [lin_line(other).line.controller]


def lin_started(board: Board, *, master: bool) -> LinMonitor:
    line = lin_line(board).line
    line.initialise(LinMode(master, 19_200))
    line.start()
    monitor = line.open(LinMonitor(LinMonitorMode(64)))
    line.activate(monitor)
    return monitor


def test_lin_lines_hear_each_other_on_their_bus(copper: Copper) -> None:
    one, other, third = (copper.plugged("usb-to-can-fd", f"HW{number}") for number in (1, 2, 3))
    lin_started(one, master=True)
    heard = lin_started(other, master=False)
    copper.timeline.run_until(200_000_000)
    while heard.take() is not None:
        pass  # STARTED and changes of state
    lin_line(one).line.send(LinFrame(0x10, b"\x01\x02"))
    copper.timeline.run_until(300_000_000)
    assert heard.take() == LinFrame(0x10, b"\x01\x02")
    assert lin_line(third).line.status().frames_received == 0  # never started


def test_an_unconnected_lin_line_hears_nobody(copper: Copper) -> None:
    one = catalogue.build(
        catalogue.kind("usb-to-can-fd"), 1, "HW1", (), copper.machine._replace(buses={**copper.can})
    )
    other = copper.plugged("usb-to-can-fd", "HW2")
    assert (lin_line(one).info.bus, lin_line(other).info.bus) == ("", "lin0")
    lin_started(one, master=True)
    lin_started(other, master=False)
    copper.timeline.run_until(200_000_000)
    lin_line(one).line.send(LinFrame(0x10, b"\x01"))
    copper.timeline.run_until(300_000_000)
    assert lin_line(one).line.status().frames_sent == 1
    assert lin_line(other).line.status().frames_received == 0


@pytest.mark.parametrize(
    ("buses", "error", "why"),
    [
        (("can0",), BadValue, "usb-to-can has 2 lines, not 1; name a bus for each"),
        (("can0", "can1", "can0"), BadValue, "usb-to-can has 2 lines, not 3"),
        (("can0", "can7"), NoSuchBoard, "no bus 'can7' for CAN-2; there are can0, can1, lin0"),
        (("can0", "lin0"), Unsupported, "usb-to-can: CAN-2 needs a CAN bus, which 'lin0' is not"),
    ],
)
def test_wrong_buses_plug_nothing(
    copper: Copper, buses: tuple[str, ...], error: type[CanwireError], why: str
) -> None:
    with pytest.raises(error, match=re.escape(why)):
        copper.plugged("usb-to-can", "HW1", *buses)
    assert [bus.nodes for bus in copper.buses.values()] == [[], [], []]


def test_a_line_without_a_bus_of_its_type_plugs_nothing(copper: Copper) -> None:
    lin = Connector("LIN", USB_TO_CAN_FD_LIN, "can0")
    mixed = BoardKind("mixed", CLASS, "Mixed", (TOY.connectors[0], lin))
    with pytest.raises(Unsupported, match="LIN-1 needs a LIN bus"):
        catalogue.build(mixed, 1, "HW1", (), copper.machine)
    assert copper.can["can0"].nodes == []


@each("text", ["HW1", "HW123456", "HW000001", "HW-a:b[c]/~!?#", "HW" + "x" * 14])
def test_hardware_ids(text: str) -> None:
    assert checked_hardware_id(text) == text


@pytest.mark.parametrize(
    "text", ["", "HW", "hw1", "1", "HW 1", "HW1\n", "HW(1)", "HWä", "HW" + "x" * 15, 17, None]
)
def test_no_hardware_ids(copper: Copper, text: str) -> None:
    with pytest.raises(BadValue, match=r"hardware id .*: HW and 1 to 14 printable"):
        checked_hardware_id(text)
    with pytest.raises(BadValue, match="hardware id"):
        copper.plugged("usb-to-can", text)


@each("text", ["", " ", "can 0", "can0\n", "(can0)", "HW1:0", "x" * 65, 5])
def test_no_bus_names(text: str) -> None:
    with pytest.raises(BadValue, match="bus name"):
        checked_bus_name(text)


def test_unknown_kinds_name_the_known_ones() -> None:
    with pytest.raises(NoSuchBoard) as raised:
        catalogue.kind("usb-to-lin")
    assert str(raised.value) == "no board kind 'usb-to-lin'; there are " + ", ".join(sorted(catalogue.KINDS))


def test_other_packages_bring_kinds(plug_ins: list[EntryPoint], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board_module, "TOY", TOY, raising=False)
    plug_ins += [
        EntryPoint("toy", "canwire.boards.board:TOY", catalogue.GROUP),
        EntryPoint("not-a-board", "canwire.boards.board:TOY", "another.group"),
    ]
    assert catalogue.kind_names() == sorted(["toy", *catalogue.KINDS])
    assert catalogue.kind("toy") is TOY


def test_our_own_kinds_stay_ours(plug_ins: list[EntryPoint]) -> None:
    plug_ins.append(EntryPoint("usb-to-can", "nowhere:KIND", catalogue.GROUP))
    assert catalogue.kind("usb-to-can") is catalogue.KINDS["usb-to-can"]


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("no_such_module:KIND", "does not load (ModuleNotFoundError"),
        ("canwire.boards.board:NOTHING", "does not load (AttributeError"),
        ("canwire.boards.board:MANUFACTURER", "is 'canwire (simulated)', not a BoardKind of that name"),
        ("canwire.boards.catalogue:KINDS", "not a BoardKind of that name"),
    ],
)
def test_a_broken_plug_in_matters_only_to_its_kind(plug_ins: list[EntryPoint], value: str, why: str) -> None:
    plug_ins.append(EntryPoint("broken", value, catalogue.GROUP))
    assert catalogue.kind("usb-to-can").name == "usb-to-can"
    assert "broken" in catalogue.kind_names()
    with pytest.raises(NoSuchBoard) as raised:
        catalogue.kind("broken")
    assert str(raised.value).startswith(f"board kind 'broken': its plug-in {value} ")
    assert why in str(raised.value)


def test_a_plug_in_under_another_name_is_broken(
    plug_ins: list[EntryPoint], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(board_module, "TOY", TOY, raising=False)
    plug_ins.append(EntryPoint("game", "canwire.boards.board:TOY", catalogue.GROUP))
    with pytest.raises(NoSuchBoard, match="is the kind 'toy', not a BoardKind of that name"):
        catalogue.kind("game")


@pytest.mark.parametrize(
    ("device_class", "connectors", "why"),
    [
        ("no guid", TOY.connectors, "board kind 'bad': device_class 'no guid' is no GUID"),
        (CLASS, (), "board kind 'bad': a board has one connector at least"),
    ],
)
def test_rows_check_themselves(device_class: str, connectors: tuple[Connector, ...], why: str) -> None:
    with pytest.raises(BadValue, match=re.escape(why)):
        BoardKind("bad", device_class, "Bad", connectors)
