"""Board kinds by name, boards made after them, and controllers on and off the copper."""

from __future__ import annotations

import re
from importlib.metadata import EntryPoint, EntryPoints
from uuid import UUID

import pytest

from canwire import BadValue, BitTiming, CanwireError, Frame, NoSuchBoard, Unsupported
from canwire.boards import board as board_module
from canwire.boards import catalogue, figures
from canwire.boards.board import Board, BoardKind, Connector, checked_bus_name, checked_hardware_id
from canwire.boards.channel import Channel
from canwire.bus.can_bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline

CLASS = "661DC760-AFA5-4D55-86F5-FABC63600A54"
TOY = BoardKind("toy", CLASS, "Toy", (Connector("CAN", figures.USB_TO_CAN, "can0"),))
SETTINGS = LineSettings(BitTiming.for_bit_rate(500_000), BitTiming.for_bit_rate(2_000_000))


class Copper:
    """A timeline and two buses."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.buses = {name: CanBus(self.timeline, name) for name in ("can0", "can1")}

    def plugged(self, name: str, hardware_id: str, *buses: str) -> Board:
        return catalogue.build(catalogue.kind(name), 7, hardware_id, buses, self.buses, self.timeline)


@pytest.fixture
def copper() -> Copper:
    return Copper()


@pytest.fixture
def plug_ins(monkeypatch: pytest.MonkeyPatch) -> list[EntryPoint]:
    """What other packages bring, as far as the catalogue can tell."""
    brought: list[EntryPoint] = []
    monkeypatch.setattr(catalogue, "entry_points", lambda group: EntryPoints(brought).select(group=group))
    return brought


def started(board: Board, line: int) -> Channel:
    slot = board.lines[line].line
    channel = slot.open(Channel(64, 64))
    assert slot.driver is not None
    slot.driver.configure(SETTINGS)
    slot.driver.start(slot.timeline.now_ns, integrated=True)
    return channel


@pytest.mark.conforms("X3-01")
@pytest.mark.parametrize(
    ("name", "device_class", "description"),
    [
        ("usb-to-can-fd", "B9AAAF39-B9B9-4850-9402-7D8250C7B88F", "USB-to-CAN FD (simulated)"),
        ("usb-to-can", "2219F6A0-732A-4750-B66F-0AE731FB40E1", "USB-to-CAN V2 (simulated)"),
    ],
)
def test_a_board_describes_itself(copper: Copper, name: str, device_class: str, description: str) -> None:
    """Device classes: reference/vci.md section 6."""
    info = copper.plugged(name, "HW000042").info
    assert (info.id, info.kind, info.hardware_id) == (7, name, "HW000042")
    assert UUID(info.device_class) == UUID(device_class)
    assert (info.description, info.manufacturer) == (description, "canwire (simulated)")
    assert [(line.name, line.bus_type, line.bus) for line in info.lines] == [
        ("CAN-1", "CAN", "can0"),
        ("CAN-2", "CAN", "can0"),
    ]
    versions = (info.driver_version, info.hardware_version, info.firmware_version)
    assert [len(version) for version in versions] == [4, 4, 2]


@pytest.mark.conforms("X3-01")
def test_lines_tell_what_they_can() -> None:
    fd, classic = (catalogue.kind(name).line_infos(()) for name in ("usb-to-can-fd", "usb-to-can"))
    assert [line.capabilities for line in fd] == [figures.USB_TO_CAN_FD] * 2
    assert [line.capabilities for line in classic] == [figures.USB_TO_CAN] * 2


def test_lines_are_counted_for_each_kind_of_bus() -> None:
    can, lin = Connector("CAN", figures.USB_TO_CAN, "can0"), Connector("LIN", figures.USB_TO_CAN, "lin0")
    mixed = BoardKind("mixed", CLASS, "Mixed", (can, lin, can))
    assert [(line.name, line.bus) for line in mixed.line_infos(())] == [
        ("CAN-1", "can0"),
        ("LIN-1", "lin0"),
        ("CAN-2", "can0"),
    ]


def test_lines_go_where_they_are_told(copper: Copper) -> None:
    board = copper.plugged("usb-to-can", "HW1", "can1", "can0")
    assert [line.info.bus for line in board.lines] == ["can1", "can0"]
    assert [line.bus for line in board.lines] == [copper.buses["can1"], copper.buses["can0"]]
    assert [line.line.controller.bus for line in board.lines] == [line.bus for line in board.lines]
    assert [line.line.name for line in board.lines] == ["HW1:0", "HW1:1"]
    assert tuple(line.info for line in board.lines) == board.info.lines


def test_boards_on_one_bus_hear_each_other(copper: Copper) -> None:
    one, other = copper.plugged("usb-to-can-fd", "HW1"), copper.plugged("usb-to-can", "HW2")
    sender, receiver = started(one, 0), started(other, 1)
    one.lines[0].line.send(sender, Frame(0x123, b"\x11"))
    copper.timeline.run_until_idle(10**9)
    assert receiver.receive.take_frame() == Frame(0x123, b"\x11")


def test_a_pulled_board_is_off_the_copper(copper: Copper) -> None:
    one, other = copper.plugged("usb-to-can-fd", "HW1"), copper.plugged("usb-to-can-fd", "HW2")
    sender, receiver = started(one, 0), started(other, 0)
    one.lines[0].line.send(sender, Frame(0x123, bytes(8)))
    copper.timeline.run_until(100_000)  # in the middle of the frame
    catalogue.pull(one)
    catalogue.pull(one)
    copper.timeline.run_until_idle(10**9)
    assert receiver.receive.take_frame() is None
    assert other.lines[0].line.controller.errors == 1  # the others see the frame break off
    assert [line.line.controller.bus for line in one.lines] == [None, None]
    assert [line.line.controller.running for line in one.lines] == [False, False]
    assert [node.bus for node in copper.buses["can0"].nodes] == [copper.buses["can0"]] * 2


@pytest.mark.parametrize(
    ("buses", "error", "why"),
    [
        (("can0",), BadValue, "usb-to-can has 2 lines, not 1; name a bus for each"),
        (("can0", "can1", "can0"), BadValue, "usb-to-can has 2 lines, not 3"),
        (("can0", "can7"), NoSuchBoard, "no bus 'can7' for CAN-2; there are can0, can1"),
    ],
)
def test_wrong_buses_plug_nothing(
    copper: Copper, buses: tuple[str, ...], error: type[CanwireError], why: str
) -> None:
    with pytest.raises(error, match=re.escape(why)):
        copper.plugged("usb-to-can", "HW1", *buses)
    assert [bus.nodes for bus in copper.buses.values()] == [[], []]


def test_a_line_without_a_bus_of_its_type_plugs_nothing(copper: Copper) -> None:
    lin = Connector("LIN", figures.USB_TO_CAN, "can0")
    mixed = BoardKind("mixed", CLASS, "Mixed", (TOY.connectors[0], lin))
    with pytest.raises(Unsupported, match="LIN-1 needs a LIN bus"):
        catalogue.build(mixed, 1, "HW1", (), copper.buses, copper.timeline)
    assert copper.buses["can0"].nodes == []


@pytest.mark.parametrize("text", ["HW1", "HW123456", "HW000001", "HW-a:b[c]/~!?#", "HW" + "x" * 14])
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


@pytest.mark.parametrize("text", ["", " ", "can 0", "can0\n", "(can0)", "HW1:0", "x" * 65, 5])
def test_no_bus_names(text: str) -> None:
    with pytest.raises(BadValue, match="bus name"):
        checked_bus_name(text)


def test_unknown_kinds_name_the_known_ones() -> None:
    with pytest.raises(NoSuchBoard) as raised:
        catalogue.kind("usb-to-lin")
    assert str(raised.value) == "no board kind 'usb-to-lin'; there are usb-to-can, usb-to-can-fd"


def test_other_packages_bring_kinds(plug_ins: list[EntryPoint], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board_module, "TOY", TOY, raising=False)
    plug_ins += [
        EntryPoint("toy", "canwire.boards.board:TOY", catalogue.GROUP),
        EntryPoint("not-a-board", "canwire.boards.board:TOY", "another.group"),
    ]
    assert catalogue.kind_names() == ["toy", "usb-to-can", "usb-to-can-fd"]
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
