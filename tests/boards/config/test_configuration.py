"""canwire.toml: what it may say, and what it is told when it says something else."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, ControllerOptions, DelayCompensation
from canwire.boards import catalogue, figures
from canwire.boards.board import CAN, BoardKind, Connector
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig, Option, options
from canwire.boards.isa import IsaPlace
from canwire.boards.kinds import KINDS, USUAL_BOARDS
from canwire.errors import BadConfig
from tests.cases import each
from tests.effort import examples

WHOLE = """
# the workshop
[[bus]]
name = "can0"
bit_rate = 250_000
data_bit_rate = 4_000_000
length_m = 12
node_delay_ns = 75.5

[[bus]]
name = "body"

[[board]]
kind = "usb-to-can-fd"
serial = "HW123456"
buses = ["can0", "body", "lin0"]

[[board]]
kind = "usb-to-can"

[[bus]]
name = "lin0"
type = "lin"
bit_rate = 9_600
"""
BUS = '[[bus]]\nname = "can0"\n'
NAMES = ": 1 to 64 characters, no blanks, parentheses or colons"
IDS = ": HW and 1 to 14 printable characters, no blanks or parentheses: HW000001 perhaps"
LIN = '[[bus]]\nname = "lin0"\ntype = "lin"\n'
FD = '[[board]]\nkind = "usb-to-can-fd"\n'
BOARD = '[[board]]\nkind = "usb-to-can"\n'


def complaint(text: str) -> str:
    with pytest.raises(BadConfig) as raised:
        Config.parse(text)
    start, message = str(raised.value).split(": ", 1)
    assert start == "canwire.toml"
    return message


def test_a_whole_file() -> None:
    config = Config.parse(WHOLE)
    assert config.bus == (
        BusConfig(name="can0", bit_rate=250_000, data_bit_rate=4_000_000, length_m=12.0, node_delay_ns=75.5),
        BusConfig(
            name="body", type="can", bit_rate=None, data_bit_rate=None, length_m=0.0, node_delay_ns=0.0
        ),
        BusConfig(name="lin0", type="lin", bit_rate=9_600),
    )
    assert config.board == (
        BoardConfig(kind="usb-to-can-fd", serial="HW123456", buses=("can0", "body", "lin0")),
        BoardConfig(kind="usb-to-can", serial="", buses=()),
    )


def test_an_empty_file_is_a_bus_without_boards() -> None:
    assert Config.parse("") == Config(bus=Config.default().bus, board=())


def test_rates_that_are_left_out() -> None:
    assert BusConfig(name="x").usual_rate == 500_000
    assert BusConfig(name="x", type="lin").usual_rate == 19_200
    assert BusConfig(name="x", type="lin", bit_rate=9_600).usual_rate == 9_600


def test_a_lin_line_without_its_bus_is_unconnected() -> None:
    """Files from before there was LIN still do."""
    config = Config.parse(BUS + FD)
    assert config.board == (BoardConfig(kind="usb-to-can-fd"),)
    assert Config.parse(BUS + FD + "buses = ['can0', 'can0']").board[0].buses == ("can0", "can0")


@given(st.floats(0, 2_000), st.booleans(), st.booleans(), st.booleans(), st.booleans())
def test_what_a_board_s_controllers_have(
    loop_ns: float, compensation: bool, edge_filter: bool, exception: bool, tolerant: bool
) -> None:
    settings = {
        "delay_compensation": compensation,
        "edge_filter": edge_filter,
        "protocol_exception": exception,
        "fd_tolerant": tolerant and exception,
    }
    text = BUS + FD + f"loop_delay_ns = {loop_ns!r}\n"
    text += "".join(f"{name} = {str(value).lower()}\n" for name, value in settings.items())
    options = Config.parse(text).board[0].options
    assert options == ControllerOptions(
        loop_ns,
        DelayCompensation() if compensation else None,
        edge_filter=edge_filter,
        protocol_exception=exception,
        fd_tolerant=tolerant and exception,
    )


def test_the_default_world_has_one_board_of_each_kind() -> None:
    """rulings.md 30, as far as its boards exist."""
    config = Config.default()
    assert config.bus == (BusConfig(name="can0", data_bit_rate=2_000_000), BusConfig(name="lin0", type="lin"))
    assert [bus.usual_rate for bus in config.bus] == [500_000, 19_200]
    assert [board.kind for board in config.board] == list(USUAL_BOARDS)
    assert config.board[0] == BoardConfig(kind="usb-to-can-fd", serial="HW000001")
    assert len({board.serial for board in config.board}) == len(config.board)


def test_the_default_world_could_stand_in_a_file() -> None:
    config = Config.default()
    bus = BUS + "data_bit_rate = 2000000\n" + LIN
    boards = [f'[[board]]\nkind = "{board.kind}"\nserial = "{board.serial}"\n' for board in config.board]
    assert Config.parse(bus + "".join(boards)) == config


@each(
    ("text", "message"),
    [
        (BUS + "[[board]]\n", "board[0].kind: missing"),
        ("[[bus]]\n", "bus[0].name: missing"),
        (
            BUS + "speed = 5",
            "bus[0].speed: no such key; there are name, type, bit_rate, data_bit_rate, length_m, node_delay_ns, "
            "termination_ohm",
        ),
        (
            BUS + "type = 'most'",
            "bus[0].type = 'most': expected text matching regex '^(can|lin)$'",
        ),
        (LIN + "bit_rate = 500", "bus[0].bit_rate: bit_rate 500: LIN runs at 1000 to 20000 bit/s"),
        (LIN + "bit_rate = 20001", "bus[0].bit_rate: bit_rate 20001: LIN runs at 1000 to 20000 bit/s"),
        (LIN + "data_bit_rate = 20000", "bus[0].data_bit_rate: a LIN bus has one bit rate"),
        (
            BUS + LIN + FD + "buses = ['can0', 'can0', 'can0']",
            "board[0].buses[2]: 'can0' is a can bus; line 2 of usb-to-can-fd is lin",
        ),
        (
            BUS + LIN + BOARD + "buses = ['can0', 'lin0']",
            "board[0].buses[1]: 'lin0' is a lin bus; line 1 of usb-to-can is can",
        ),
        (
            BUS + LIN + FD + "buses = ['can0', 'can0', 'lin7']",
            "board[0].buses[2]: no bus 'lin7'; there are can0, lin0",
        ),
        (
            BUS + FD + "buses = ['can0']",
            "board[0].buses: usb-to-can-fd has 3 lines, not 1; name a bus for each",
        ),
        (
            "[[bus]]\nname = 'lin0'\n" + BUS + FD,
            "board[0].buses, left out: 'lin0' is a can bus; line 2 of usb-to-can-fd is lin",
        ),
        (
            BUS + BOARD + "bus = 'can0'",
            "board[0].bus: no such key; there are kind, serial, buses, base, irq, shared_irq, access, port, "
            "loop_delay_ns, delay_compensation, edge_filter, protocol_exception, fd_tolerant",
        ),
        (
            BUS + FD + "loop_delay_ns = 2000.5",
            "board[0].loop_delay_ns = 2000.5: expected a number <= 2000.0",
        ),
        (
            BUS + FD + "edge_filter = 1",
            "board[0].edge_filter = 1: expected true or false, got a whole number",
        ),
        (
            BUS + FD + "fd_tolerant = true\nprotocol_exception = false",
            "board[0].fd_tolerant: fd_tolerant True: it is a protocol exception, which protocol_exception switches off",
        ),
        (
            BUS + "[[board]]\nkind = 'inducan104'\nfd_tolerant = true",
            "board[0].fd_tolerant: inducan104 has none; USB-to-CAN boards have",
        ),
        (
            BUS + "[[board]]\nkind = 'slcan'\nport = 'COM3'\nloop_delay_ns = 5",
            "board[0].loop_delay_ns: slcan has none; USB-to-CAN boards have",
        ),
        ("[hub]\na = 1", "hub: no such key; there are bus, board, limits"),
        ("[bus]\nname = 'can0'", "bus: expected a list, got a table; write [[bus]], with two brackets"),
        ("board = 5", "board = 5: expected a list, got a whole number; write [[board]], with two brackets"),
        ("bus = [5]", "bus[0] = 5: expected a table, got a whole number"),
        (BUS + "bit_rate = '500k'", "bus[0].bit_rate = '500k': expected a whole number, got text"),
        (BUS + "bit_rate = 5e5", "bus[0].bit_rate = 500000.0: expected a whole number, got a number"),
        (BUS + "bit_rate = true", "bus[0].bit_rate = True: expected a whole number, got true or false"),
        (BUS + "bit_rate = 0", "bus[0].bit_rate = 0: expected a whole number >= 1"),
        (BUS + "bit_rate = 2000000", "bus[0].bit_rate = 2000000: expected a whole number <= 1000000"),
        (
            BUS + "bit_rate = 400",
            "bus[0].bit_rate: 400 bit/s cannot be made from 80000000 Hz (CAN FD nominal phase); "
            "nearest: 406 bit/s",
        ),
        (BUS + "data_bit_rate = 250000", "bus[0].data_bit_rate: 250000 is below bit_rate 500000"),
        (BUS + "data_bit_rate = 'x'", "bus[0].data_bit_rate = 'x': expected a whole number, got text"),
        (BUS + "length_m = -1", "bus[0].length_m = -1: expected a number >= 0.0"),
        (BUS + "length_m = nan", "bus[0].length_m = nan: expected a number >= 0.0"),
        (BUS + "node_delay_ns = inf", "bus[0].node_delay_ns = inf: expected a number <= 100000.0"),
        ("[[bus]]\nname = 'can 0'", "bus[0].name: bus name 'can 0'" + NAMES),
        ("[[bus]]\nname = ''", "bus[0].name: bus name ''" + NAMES),
        (BUS + "[[bus]]\nname = 'b'\n" + BUS, "bus[2].name: 'can0' twice; bus[0] has it too"),
        (
            BOARD + "serial = 'HW1'\n" + BOARD + BOARD + "serial = 'HW1'",
            "board[2].serial: 'HW1' twice; board[0] has it too",
        ),
        (BOARD + "serial = '17'", "board[0].serial: hardware id '17'" + IDS),
        (
            "[[board]]\nkind = 'usb-to-lin'",
            "board[0].kind: no board kind 'usb-to-lin'; there are " + ", ".join(sorted(KINDS)),
        ),
        (
            BUS + BOARD + BOARD + "buses = ['can7', 'can0']",
            "board[1].buses[0]: no bus 'can7'; there are can0",
        ),
        (BOARD + "buses = ['can0', 'x']", "board[0].buses[1]: no bus 'x'; there are can0, lin0"),
        (BOARD + "buses = ['can0']", "board[0].buses: usb-to-can has 2 lines, not 1; name a bus for each"),
        (BOARD + "buses = 'can0'", "board[0].buses = 'can0': expected a list, got text"),
        (BOARD + "buses = ['can0', 5]", "board[0].buses[1] = 5: expected text, got a whole number"),
        ("[[bus]]\nname = 'engine'\n" + BOARD, "board[0].buses, left out: no bus 'can0'; there are engine"),
        ("bus = []\n" + BOARD, "board[0].buses, left out: no bus 'can0'; there are none"),
        ("[[bus]]\nname = " + repr("x" * 70), f"bus[0].name: bus name {'x' * 70!r}" + NAMES),
        (
            BUS + "bit_rate = " + repr("x" * 70),
            f"bus[0].bit_rate = '{'x' * 59}...: expected a whole number, got text",
        ),
    ],
)
def test_what_a_file_is_told(text: str, message: str) -> None:
    assert complaint(text) == message


@each(
    ("text", "why"),
    [
        ("[[bus]\n", "(at line 1, column 6)"),
        ("a = 1\na = 2", "Cannot overwrite a value"),
        ("a = " + "[" * 100_000, "nested too deep"),
        ("a = " + "9" * 10_000, "digits"),
    ],
)
def test_no_toml(text: str, why: str) -> None:
    assert why in complaint(text)


def test_files(tmp_path: Path) -> None:
    path = tmp_path / "canwire.toml"
    path.write_text(WHOLE, encoding="utf-8")
    assert Config.load(path) == Config.parse(WHOLE)
    path.write_bytes(b"# \xff")
    with pytest.raises(BadConfig) as raised:
        Config.load(str(path))
    assert str(raised.value) == f"{path}: byte 2 is no UTF-8: invalid start byte"
    path.write_text("x = 1")
    with pytest.raises(BadValue) as no_key:
        Config.load(path)
    assert str(no_key.value) == f"{path}: x: no such key; there are bus, board, limits"


def test_a_missing_file_and_a_directory(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="nowhere: No such file or directory"):
        Config.load(tmp_path / "nowhere")
    with pytest.raises(BadConfig, match="Is a directory"):
        Config.load(tmp_path)


def test_options_are_rows_for_documentation() -> None:
    rows = options()
    assert [(row.table, row.name) for row in rows] == [
        *(
            ("bus", name)
            for name in (
                "name",
                "type",
                "bit_rate",
                "data_bit_rate",
                "length_m",
                "node_delay_ns",
                "termination_ohm",
            )
        ),
        *(
            ("board", name)
            for name in (
                "kind",
                "serial",
                "buses",
                "base",
                "irq",
                "shared_irq",
                "access",
                "port",
                "loop_delay_ns",
                "delay_compensation",
                "edge_filter",
                "protocol_exception",
                "fd_tolerant",
            )
        ),
    ]
    help = "default data bit rate in bit/s, after BRS"
    assert rows[3] == Option("bus", "data_bit_rate", "integer", None, help)
    assert [row.type for row in rows] == [
        "string", "string", "integer", "integer", "number", "number", "number",
        "string", "string", "list of strings", "integer", "integer", "boolean", "string", "string",
        "number", "boolean", "boolean", "boolean", "boolean",
    ]  # fmt: skip
    assert all(row.help for row in rows)


def inducan104s(*settings: str) -> str:
    """A file with these boards, and boards of another kind between them."""
    return BOARD.join(f'[[board]]\nkind = "inducan104"\n{setting}\n' for setting in settings)


@pytest.fixture
def inducan104(monkeypatch: pytest.MonkeyPatch) -> None:
    """A kind by that name, whatever the catalogue has."""
    kind = BoardKind(
        name="inducan104",
        device_class="C0DE0104-0000-4000-8000-000000000104",
        description="INduCAN104",
        connectors=(Connector(CAN, figures.USB_TO_CAN, "can0"),),
    )
    monkeypatch.setitem(catalogue.KINDS, "inducan104", kind)


@pytest.mark.usefixtures("inducan104")
@pytest.mark.conforms("AC-01", "AC-03")
def test_jumpers_in_the_file() -> None:
    text = inducan104s("", 'base = 0x1A0\nirq = 10\nshared_irq = true\naccess = "port"')
    delivered, other, real = Config.parse(text).board
    assert delivered.place == IsaPlace(0x280, 5)
    assert (delivered.base, delivered.irq, delivered.access) == (None, None, "simulated")
    assert other.place is None
    assert (real.place, real.access) == (IsaPlace(0x1A0, 10, True), "port")


@pytest.mark.usefixtures("inducan104")
@pytest.mark.conforms("AC-01", "AC-03", "AC-04")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            inducan104s("base = 0x290"),
            "board[0].base: base address 290h: 100h, 120h, 140h and so on to 3E0h; usually 280h",
        ),
        (inducan104s("base = '280h'"), "board[0].base = '280h': expected a whole number, got text"),
        (inducan104s("irq = 6"), "board[0].irq: IRQ 6: 3, 4, 5, 7, 9, 10 or 11; usually 5"),
        (
            inducan104s("access = 'usb'"),
            "board[0].access = 'usb': expected text matching regex '^(simulated|port)$'",
        ),
        (
            inducan104s("serial = 'HW7'", "base = 0x280\nirq = 3"),
            "board[2].base: 280h twice; board[0] HW7 is there too",
        ),
        (
            inducan104s("base = 0x280", "irq = 3"),
            "board[2].base, left out: 280h twice; board[0] is there too",
        ),
        (
            inducan104s("base = 0x100", "base = 0x120\nirq = 5"),
            "board[2].irq: IRQ 5 twice; board[0] has it too; boards that share it all say shared_irq = true",
        ),
        (
            inducan104s("base = 0x100\nshared_irq = true", "base = 0x120"),
            "board[2].irq, left out: IRQ 5 twice; board[0] has it too; "
            "boards that share it all say shared_irq = true",
        ),
        (BOARD + "base = 0x280", "board[0].base: usb-to-can has none; inducan104 has"),
        (BOARD + BOARD + "irq = 5", "board[1].irq: usb-to-can has none; inducan104 has"),
        (BOARD + "shared_irq = true", "board[0].shared_irq: usb-to-can has none; inducan104 has"),
        (BOARD + "access = 'port'", "board[0].access: usb-to-can has none; inducan104 has"),
    ],
)
def test_jumpers_that_cannot_be(text: str, message: str) -> None:
    assert complaint(text) == message


@pytest.mark.usefixtures("inducan104")
@pytest.mark.conforms("AC-05")
def test_an_interrupt_line_that_both_share() -> None:
    text = inducan104s("shared_irq = true", "shared_irq = true\nbase = 0x300")
    assert [board.place for board in Config.parse(text).board if board.place] == [
        IsaPlace(0x280, 5, True),
        IsaPlace(0x300, 5, True),
    ]


scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5)
keys = st.sampled_from(
    [
        "bus",
        "board",
        "name",
        "type",
        "kind",
        "serial",
        "buses",
        "bit_rate",
        "length_m",
        "base",
        "irq",
        "access",
    ]
) | st.text(max_size=3)


def toml(value: object) -> str:
    """Enough of TOML to write down what hypothesis draws."""
    match value:
        case dict():
            return "{" + ", ".join(f"{toml(str(key))} = {toml(item)}" for key, item in value.items()) + "}"
        case list():
            return "[" + ", ".join(map(toml, value)) + "]"
        case bool() | None:
            return "true" if value else "false"
        case str():
            return '"' + "".join(f"\\U{ord(one):08X}" for one in value) + '"'
        case _:
            return (
                str(value).replace("e", ".0e") if "e" in str(value) and "." not in str(value) else str(value)
            )


@examples(40)
@given(
    st.dictionaries(
        keys,
        st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner)),
        max_size=3,
    )
)
def test_nothing_but_complaints(data: dict[str, object]) -> None:
    """Whatever a file holds, it is a configuration or a BadConfig that names the file."""
    text = "\n".join(f"{toml(key)} = {toml(value)}" for key, value in data.items())
    try:
        Config.parse(text)
    except BadConfig as error:
        told = str(error)
    else:
        told = "canwire.toml: nothing wrong"
    assert told.startswith("canwire.toml: ")
