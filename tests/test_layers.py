"""The house's order is law: a file imports only what stands above it. See docs/architecture.md."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from canwire import core

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "canwire"
DOOR = "canwire"

# rooms from the top of the house down; a room is a module or a package directly under canwire
ROOMS = [
    "errors",
    "version",
    "forks",
    "places",
    "platform",
    "_cython",
    "_mem",
    "values",
    "ldf",
    "databases",
    "timeline",
    "ring",
    "holding",
    "pacing",
    "held_time",
    "threads",
    "bus",
    "chips",
    "drivers",
    "boards",
    "hub",
    "lab",
    "campaigns",
    "gateway",
    "logs",
    "core",
    DOOR,
]
# behind the door: they use the package as any program does, and each only itself besides
OUTSIDE = [
    "packed",
    "vci",
    "acan",
    "candrv",
    "slcan",
    "ecus",
    "python_can",
    "pytest_hub",
    "socketcan",
    "pytest_plugin",
    "web",
    "native",
    "commands",
    "__main__",
]
# what the door finds by `canwire.NAME` without importing it: it imports them for type checkers alone
FOUND_BY_THE_DOOR = {"acan", "candrv", "ecus", "ldf", "python_can", "slcan", "vci"}
OUTSIDE_MAY = {
    "packed": set(),
    "vci": {"packed"},
    "acan": {"packed"},
    "candrv": {"packed"},
    "slcan": set(),
    "ecus": {"platform"},  # a limit of time for canopen's reader of files
    "python_can": set(),
    "pytest_hub": set(),
    "socketcan": set(),
    "pytest_plugin": set(),
    "web": {"candrv", "ldf"},
    "native": {"acan", "candrv", "packed", "vci"},  # their forms in C
    "commands": {"acan", "candrv", "ldf", "native", "slcan", "socketcan", "web"},
    "__main__": {"commands"},
}

# clocks, threads and sockets
CLOCKS = {"time", "threading", "_thread", "socket", "socketserver", "selectors", "select", "ssl", "queue",
          "concurrent", "multiprocessing", "subprocess", "signal"}  # fmt: skip
MAY_HAVE_CLOCKS = {
    "__main__",
    "pacing",
    "held_time",
    "platform",
    "threads",
    "hub",
    "commands",
    "campaigns",
    "gateway",
    "native",
    "pytest_plugin",
    "python_can",
    "socketcan",
    "web",
}
SERVES = {"slcan.serving", "slcan.wires", "slcan.tcp_wire"}  # the ASCII port server
MAY_LOCK = {
    "vci.fifo.fifo",
    "acan.service",
    "candrv.device.device",
    "candrv.program",
    "candrv.handle.waiting",
    "candrv.handle.writing",
    "ecus.canopen.ecu",
    "ecus.j1939.ecu",
}
# VCI's Lock and Unlock are its threads' own; ACAN tells on a thread; any thread may use a CANDRV handle; an ECU on a
# shared board is called by its library's threads and by its owner's
RECORD = {
    "logs.recording.files",
    "logs.recording.recorder",
    "logs.trace.packing",
}  # what happens now, in threads
VIRTUAL_CLOCKS = {"lab.event_loop"}  # asyncio wants a selector; this one passes the lab's time
OUTSIDE_WORLD = {  # real adapters: their I/O alone
    "drivers.slcan_dongle.link",
    "drivers.slcan_dongle.ports",
    "drivers.python_can.adapter",
    "drivers.python_can.gs_usb.bus",
    "logs.mf4.apart",  # and what ends a process that reads for this one
}
HUB_WITHOUT_CLOCKS = {
    "hub.protocol.board_messages",
    "hub.protocol.channel_messages",
    "hub.protocol.cyclic_messages",
    "hub.protocol.failure",
    "hub.protocol.link",
    "hub.protocol.message",
    "hub.protocol.messages",
    "hub.protocol.lin_messages",
    "hub.owner.entrance",
    "hub.owner.lockstep.keeper",
    "hub.owner.lockstep.program",
    "hub.owner.lockstep.turns",
    "hub.protocol.time_messages",
    "hub.protocol.turn_page",
    "hub.owner.session",
    "hub.owner.world",
}
HUB_FOLDERS_WITHOUT_CLOCKS = ("hub.owner.held.", "hub.owner.answers.")
# what each of the hub's rooms may import of the others; connect.py and serve.py stand on top
HUB_MAY = {
    "hub.protocol": set(),
    "hub.handles": {"hub.protocol"},
    "hub.owner": {"hub.protocol"},
    "hub.links": {"hub.protocol", "hub.owner"},
}
HUB_ON_TOP = {  # what stands in no room of the hub
    "hub",
    "hub.absence",
    "hub.bring_up",
    "hub.conflicts",
    "hub.connect",
    "hub.finding",
    "hub.in_process",
    "hub.offer",
    "hub.serve",
    "hub.usual",
    "hub.wall_clock",
    "hub.wanted_mode",
}
NEVER_EACH_OTHER = ["drivers"]  # siblings; what they share stands in the seam
SEAMS = {"drivers": {"driver", "lin_driver", "obstacles", "outside", "reporting"}}
STRANGERS = [("chips", "drivers"), ("drivers", "chips")]
CHIP_SEAMS = {"chips.host", "chips.registers"}
TOUCH_CHIPS = {
    "boards.catalogue",
    "boards.transceiver",
    "boards.can.line",
    "boards.lin.line",
    "boards.lin.splitter",
}
BUS_SEAMS = {"bus.can.node", "bus.lin.node", "bus.medium"}  # the last: lengths and delays, no bus

FILES = 20  # of a folder's own
LINES = 300
LONGEST = 500
DOOR_LINES = 653  # three lines for every public name
LONG = {  # files that need more than 300 lines; nothing needs more than 500
    "__init__.py",  # a table: all that is public
    "boards/can/connector.py",
    "boards/can/line.py",
    "bus/can/bit_level.py",
    "bus/can/bus.py",
    "bus/can/coasting.py",
    "bus/lin/bus.py",
    "bus/can/station.py",
    "hub/protocol/messages.py",
    "ring.py",
    "values/frame.py",
}


class Import(NamedTuple):
    """One imported module, at its line; `typing_only` under `if TYPE_CHECKING`."""

    importer: str
    imported: str
    line: int
    typing_only: bool
    relative: bool

    def __str__(self) -> str:
        purpose = " for types" if self.typing_only else ""
        return f"{self.importer}:{self.line} imports {self.imported}{purpose}"


def sources() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def name_of(path: Path) -> str:
    """Dotted name below canwire; the door itself is "canwire"."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    if parts[-1] == "__init__":
        parts = parts[:-1]
    return ".".join(parts) or DOOR


def room_of(name: str) -> str:
    return name.partition(".")[0]


MODULES = {name_of(path): path for path in sources()}


def imports_of(name: str, path: Path) -> Iterator[Import]:
    """Every import of a file, wherever it stands; modules of canwire by their name below it."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text, str(path))
    typing_only = {
        inner
        for node in (statements(tree) if "TYPE_CHECKING" in text else ())
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test)
        for statement in node.body
        for inner in statements(statement)
    }
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in statements(tree):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found = list(from_import(node, package))
        else:
            continue
        for module in found:
            relative = isinstance(node, ast.ImportFrom) and node.level > 0
            yield Import(name, module, node.lineno, node in typing_only, relative)


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """This one and all that stand in it: an import is a statement, and `ast.walk` takes long for all expressions."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):
            yield from statements(child)


def from_import(node: ast.ImportFrom, package: str) -> Iterator[str]:
    """`from canwire.bus import node` imports canwire.bus.can.node, `from canwire import Frame` the door."""
    base = node.module or ""
    if node.level:
        inside = "" if package == DOOR else package
        above = inside.split(".")[: len(inside.split(".")) - node.level + 1] if inside else []
        base = ".".join(filter(None, [DOOR, *above, base]))
    for alias in node.names:
        deeper = f"{base}.{alias.name}"
        is_module = deeper.startswith(f"{DOOR}.") and deeper.removeprefix(f"{DOOR}.") in MODULES
        yield deeper if is_module else base


def own(found: Import) -> str | None:
    """What of canwire is imported, below it; None for other packages."""
    if found.imported == DOOR:
        return DOOR
    return found.imported.removeprefix(f"{DOOR}.") if found.imported.startswith(f"{DOOR}.") else None


@functools.cache
def imports() -> list[Import]:
    """Of all files."""
    return [found for name, path in MODULES.items() for found in imports_of(name, path)]


def complaints(wrong: list[Import]) -> str:
    return "\n".join(dict.fromkeys(map(str, wrong)))


def test_every_file_has_its_place() -> None:
    assert sorted({room_of(name) for name in MODULES} - {*ROOMS, *OUTSIDE}) == []


def test_every_own_import_exists() -> None:
    wrong = [found for found in imports() if own(found) not in {None, DOOR, *MODULES}]
    assert not wrong, complaints(wrong)


def test_no_relative_imports_hide_the_order() -> None:
    relative = [found for found in imports() if found.relative]
    assert not relative, complaints(relative)


def test_imports_point_up_the_house() -> None:
    wrong = []
    for found in imports():
        target = own(found)
        here = room_of(found.importer)
        if target is None or here in OUTSIDE:
            continue
        there = room_of(target)
        if here == there and here != DOOR:
            continue
        if here == DOOR and found.typing_only and there in FOUND_BY_THE_DOOR:
            continue
        if there not in ROOMS or ROOMS.index(there) >= ROOMS.index(here):
            wrong.append(found)
    assert not wrong, complaints(wrong)


def test_nobody_behind_the_door_looks_further_in() -> None:
    wrong = []
    for found in imports():
        target, here = own(found), room_of(found.importer)
        if target is not None and here in OUTSIDE:
            allowed = {DOOR, here, *OUTSIDE_MAY[here]}
            if room_of(target) not in allowed:
                wrong.append(found)
    assert not wrong, complaints(wrong)


def test_no_circles_inside_a_room() -> None:
    """The order inside a room is free, a circle is not, even for types alone."""
    refuse_circles(
        found for found in imports() if DOOR != room_of(found.importer) == room_of(own(found) or "")
    )


def refuse_circles(looked_at: Iterable[Import]) -> None:
    """Nothing imports itself by way of these."""
    inside = [(found, own(found) or "") for found in looked_at]
    edges: dict[str, set[str]] = {}
    for found, target in inside:
        edges.setdefault(found.importer, set()).add(target)

    def reach(name: str, seen: set[str]) -> set[str]:
        if name not in seen:
            seen.add(name)
            for following in edges.get(name, ()):
                reach(following, seen)
        return seen

    reached = {name: reach(name, set()) for _, name in inside}
    wrong = [found for found, target in inside if found.importer in reached[target]]
    assert not wrong, f"in a circle:\n{complaints(wrong)}"


def folders() -> list[Path]:
    return sorted({path.parent for path in sources()})


def files_of(folder: Path) -> list[Path]:
    """Its own ones; not __init__.py, which every folder has."""
    return sorted(path for path in folder.glob("*.py") if path.name != "__init__.py")


def test_a_folder_has_room() -> None:
    full = {folder: count for folder in folders() if (count := len(files_of(folder))) > FILES}
    assert not full, "make folders for the ideas of " + ", ".join(
        f"{folder.relative_to(ROOT)}: {count} files" for folder, count in full.items()
    )


def test_prefixes_do_not_do_the_work_of_folders() -> None:
    """held.py, held_channel.py and held_lin.py want to be held/."""
    alike: dict[tuple[Path, str], list[str]] = {}
    for folder in folders():
        for path in files_of(folder):
            prefix = path.stem.lstrip("_").partition("_")[0]
            alike.setdefault((folder, prefix), []).append(path.name)
    wrong = [
        f"{folder.relative_to(ROOT)}/{prefix}/ for {names}"
        for (folder, prefix), names in alike.items()
        if len(names) > 2
    ]
    assert not wrong, "make " + ", ".join(wrong)


def test_nothing_else_stands_on_top_of_the_hub() -> None:
    loose = {
        name for name in MODULES if room_of(name) == "hub" and ".".join(name.split(".")[:2]) not in HUB_MAY
    }
    assert loose == HUB_ON_TOP


def test_the_order_of_the_hub_s_rooms() -> None:
    """Protocol below handles and owner, which do not know each other; links over both."""

    def of_hub(name: str) -> str:
        return ".".join(name.split(".")[:2])

    wrong = [
        found
        for found in imports()
        if of_hub(found.importer) in HUB_MAY
        and room_of(own(found) or "") == "hub"
        and of_hub(own(found) or "") not in HUB_MAY[of_hub(found.importer)] | {of_hub(found.importer)}
    ]
    assert not wrong, complaints(wrong)


@pytest.mark.parametrize("room", NEVER_EACH_OTHER)
def test_siblings_never_import_each_other(room: str) -> None:
    seam = {f"{room}.{name}" for name in SEAMS[room]} | {room}
    wrong = [
        found
        for found in imports()
        if room_of(found.importer) == room == room_of(own(found) or "")
        and own(found) not in seam
        and found.importer.split(".")[:2] != (own(found) or "").split(".")[:2]  # files of one sibling
    ]
    assert not wrong, complaints(wrong)


@pytest.mark.parametrize(("one", "other"), STRANGERS)
def test_a_driver_never_sees_a_model(one: str, other: str) -> None:
    """But its register map, chips/*/register_map.py, and the seams."""
    wrong = [
        found
        for found in imports()
        if room_of(found.importer) == one
        and room_of(own(found) or "") == other
        and not found.imported.endswith(".register_map")
        and own(found) not in CHIP_SEAMS
    ]
    assert not wrong, complaints(wrong)


def test_only_catalogue_and_line_touch_chips() -> None:
    wrong = [
        found
        for found in imports()
        if room_of(found.importer) in ("boards", "hub", "lab")
        and room_of(own(found) or "") == "chips"
        and found.importer not in TOUCH_CHIPS
    ]
    assert not wrong, complaints(wrong)


def test_only_the_catalogue_puts_chips_on_buses() -> None:
    """And a transceiver takes one off. Nothing else in boards sees a whole bus; node.py of either kind is the seam."""
    wrong = [
        found
        for found in imports()
        if room_of(found.importer) == "boards"
        and found.importer not in ("boards.catalogue", "boards.transceiver")
        and (own(found) or "").startswith("bus.")
        and own(found) not in BUS_SEAMS
    ]
    assert not wrong, complaints(wrong)


def test_clocks_threads_and_sockets_stay_where_they_belong() -> None:
    wrong = [
        found
        for found in imports()
        if found.imported.partition(".")[0] in CLOCKS
        and (
            room_of(found.importer) not in MAY_HAVE_CLOCKS
            or found.importer in HUB_WITHOUT_CLOCKS
            or found.importer.startswith(HUB_FOLDERS_WITHOUT_CLOCKS)
        )
        and found.importer not in MAY_LOCK | OUTSIDE_WORLD | RECORD | SERVES | VIRTUAL_CLOCKS
        and not found.typing_only
    ]
    assert not wrong, complaints(wrong)


def test_length() -> None:
    """300 lines; 500 for the listed ones."""
    longer = {}
    for path in sources():
        name, lines = path.relative_to(SOURCE).as_posix(), len(path.read_text("utf-8").splitlines())
        limit = LONGEST if name in LONG else LINES
        if lines > (DOOR_LINES if path == SOURCE / "__init__.py" else limit):
            longer[name] = lines
    assert longer == {}


def test_the_list_of_long_files_is_not_longer_than_needed() -> None:
    short = [name for name in LONG if len((SOURCE / name).read_text(encoding="utf-8").splitlines()) <= LINES]
    assert short == []


def core_names() -> list[str]:
    """CORE of setup.py, in names below canwire."""
    tree = ast.parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    found = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "CORE"
    ]
    assert len(found) == 1
    return [name.removeprefix(f"{DOOR}.") for name in found[0]]


def test_each_core_file_has_its_declarations() -> None:
    missing = [name for name in core_names() if not (SOURCE / (name.replace(".", "/") + ".pxd")).exists()]
    assert missing == []


def test_each_core_file_stands_in_a_package_that_cimport_can_find() -> None:
    folders = {(SOURCE / name.replace(".", "/")).parent for name in core_names()} | {SOURCE}
    assert [str(folder) for folder in sorted(folders) if not (folder / "__init__.pxd").exists()] == []


def test_no_declarations_without_a_core_file() -> None:
    declared = {
        ".".join(path.relative_to(SOURCE).with_suffix("").parts) for path in SOURCE.rglob("*.pxd")
    } - {"_mem", "values.hex_text"}  # included where they are cimported: they have no modules of their own
    spare = [name for name in declared - set(core_names()) if not name.endswith("__init__")]
    assert sorted(spare) == []


def test_each_core_file_counts_for_core_mode() -> None:
    listed = sorted(module.__name__.removeprefix("canwire.") for module in core.MODULES)
    assert listed == sorted(core_names())


def test_declarations_have_no_typed_memoryviews() -> None:
    """One of them in `_mem.pxd` makes each extension 20,000 lines of C longer, and the build twice as long."""
    view = re.compile(r"\[\s*:+\s*1?\s*[\],]")
    assert [path.name for path in SOURCE.rglob("*.pxd") if view.search(path.read_text("utf-8"))] == []


def test_the_core_counts_no_index_from_the_end() -> None:
    """Compiled without wrap-around, such an index reads outside the buffer instead."""
    found = []
    for name in core_names():
        path = SOURCE / (name.replace(".", "/") + ".py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.UnaryOp):
                found.append(f"{name}:{node.lineno}")
    assert found == []


def test_files_that_the_architecture_page_names_exist() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"(?<![\w*./])(?:[\w-]+/)+[\w-]+\.(?:py|pxd|md|toml)\b", text))
    assert named
    gone = [
        name for name in named if not any((place / name).exists() for place in (ROOT, SOURCE.parent, SOURCE))
    ]
    assert (
        sorted(name for name in gone if not name.startswith("shared/")) == []
    )  # those stand beside the tree
