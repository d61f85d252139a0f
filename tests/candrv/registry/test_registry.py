"""The registry. Source: CANDRV manual, chapters 5 and 6; rulings.md 17."""

from __future__ import annotations

import dataclasses
import re
import tomllib
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from canwire import BadConfig, BadValue, InUse
from canwire.candrv.registry import file as registry_file
from canwire.candrv.registry.registry import ROWS, RegistryStore, Settings, check_spi, row_of
from canwire.candrv.registry.settings import FIELDS, IDENTITY

# the table of 6.2
DEFAULTS = {
    "Dll": "candrv.dll",
    "FriendlyName": "PicoCOM CAN driver",
    "Prefix": "CID",
    "Index": 1,
    "Order": 20,
    "DeviceArrayIndex": 0,
    "Ioctl": 4,
    "TxMode": 7,
    "SendBufferSize": 100,
    "EventQueueSize": 200,
    "Priority256": 103,
    "Debug": 0,
    "Baudrate": 1000000,
    "CanMode2B": 0,
    "Format": 0,
    "Virtualize": 0,
    "AcceptanceCode": 0,
    "AcceptanceMask": 0,
    "MaskActive": 0,
    "Align": 0,
    "IRQ": 30,
    "DirectInterface": 0,
    "SPIDevice": "SPI3:",
}
FILE = """\
# my world

[[bus]]
name = "can0"  # the only one
bit_rate = 500_000

[candrv.CID1]      # the first
# as fast as the fans can
Baudrate = 500000  # bit/s
FriendlyName = \"\"\"
[candrv.CID7]
Align = 3\"\"\"

# the second
[candrv.CID2]
Order = 10
DeviceArrayIndex = 1

[[board]]
kind = "picocom1"  # last line"""


@pytest.fixture
def store(tmp_path: Path) -> RegistryStore:
    path = tmp_path / "canwire.toml"
    path.write_text(FILE, encoding="utf-8")
    return RegistryStore(path)


@pytest.fixture
def empty(tmp_path: Path) -> RegistryStore:
    return RegistryStore(tmp_path / "canwire.toml")


def text_of(store: RegistryStore) -> str:
    return store.path.read_bytes().decode()


def others_of(store: RegistryStore) -> dict[str, Any]:
    return {key: value for key, value in tomllib.loads(text_of(store)).items() if key != "candrv"}


# entries


@pytest.mark.conforms("FS-03")
@pytest.mark.parametrize(("name", "value"), DEFAULTS.items())
def test_defaults(name: str, value: int | str, empty: RegistryStore) -> None:
    assert ROWS[name].default == value
    assert getattr(Settings(), FIELDS[name]) == value
    assert empty.get("CID1", name) == value


@pytest.mark.conforms("FS-13")
def test_the_entries_are_the_manuals_and_one_of_ours() -> None:
    assert [name for name, row in ROWS.items() if not row.ours and name != "UseTxIRQ"] == list(DEFAULTS)
    assert [name for name, row in ROWS.items() if row.ours] == ["Board"]
    assert [field.name for field in dataclasses.fields(Settings)] == list(FIELDS.values())
    assert all(row.effect and row.range and row.type in ("DWORD", "String") for row in ROWS.values())


@pytest.mark.conforms("FS-07")
@pytest.mark.parametrize("name", ["Priority256", "IRQ", "Dll", "Ioctl"])
def test_what_the_virtual_board_ignores_says_so(name: str, empty: RegistryStore) -> None:
    assert "ignores it" in ROWS[name].effect
    value = "other.dll" if name == "Dll" else 77
    empty.set("CID1", name, value)
    assert empty.get("CID1", name) == value


@pytest.mark.conforms("FS-05")
@pytest.mark.parametrize(
    ("stored", "tx_mode"),
    [
        ({}, 7),
        ({"UseTxIRQ": 0}, 0),
        ({"UseTxIRQ": 1}, 7),
        ({"UseTxIRQ": 1, "TxMode": 0}, 0),
        ({"TxMode": 3, "UseTxIRQ": 0}, 3),
        ({"TxMode": 5}, 5),
    ],
)
def test_use_tx_irq(stored: dict[str, int], tx_mode: int) -> None:
    assert Settings.of(stored).tx_mode == tx_mode


@pytest.mark.conforms("FS-61", "FS-62", "FS-63")
@pytest.mark.parametrize("mode", range(8))
def test_bits_of_tx_mode(mode: int) -> None:
    one = Settings.of({"TxMode": mode})
    assert one.send_buffer_mode + 2 * one.transmitted_events + 4 * one.sent_on_wire == mode


@pytest.mark.conforms("FS-01")
@pytest.mark.parametrize(
    ("stored", "name"),
    [
        ({}, "CID1:"),
        ({"Prefix": "CAN", "Index": 0}, "CAN0:"),
        ({"Index": 9}, "CID9:"),
        ({"prefix": "XYZ"}, "XYZ1:"),
    ],
)
def test_device_names(stored: dict[str, Any], name: str) -> None:
    assert Settings.of(stored).device == name
    assert Settings.of({}, "CID4").device == "CID4:"
    assert Settings.of({}, "Second").device == "CID1:"


@pytest.mark.conforms("FS-01", "FS-07")
@pytest.mark.parametrize(
    ("name", "value"),
    [
        *[("Prefix", value) for value in ("cid", "CI", "CIDX", "C1D", "CID\n", "", 7)],
        *[("Index", value) for value in (-1, 10, "1", 1.0, True)],
        *[("TxMode", 8), ("UseTxIRQ", 2), ("SendBufferSize", 0), ("EventQueueSize", 0)],
        *[("Priority256", 256), ("Priority256", -1), ("IRQ", 256), ("IRQ", "30")],
        *[("Baudrate", 0), ("Baudrate", 1_000_001), ("CanMode2B", 2), ("Format", 3), ("Virtualize", 2)],
        *[("AcceptanceCode", 1 << 32), ("MaskActive", 2), ("Align", 4), ("Debug", 1 << 32)],
        *[("DirectInterface", 2), ("SPIDevice", "SPI3"), ("SPIDevice", "spi3:"), ("DeviceArrayIndex", 10)],
        *[("Order", -1), ("Ioctl", None), ("FriendlyName", 5)],
    ],
)
def test_impossible_values(name: str, value: Any, store: RegistryStore) -> None:
    with pytest.raises(BadValue, match=f"{name} = "):
        Settings.of({name: value})
    with pytest.raises(BadValue, match=name):
        store.set("CID1", name, value)
    assert text_of(store) == FILE


def test_unknown_entries(store: RegistryStore) -> None:
    for call in (store.get, store.delete, lambda device, name: store.set(device, name, 1)):
        with pytest.raises(BadValue, match=r"'Colour'; there are Dll, FriendlyName, .*SPIDevice"):
            call("CID1", "Colour")


def test_names_of_entries_know_no_case() -> None:
    assert row_of("txmode") is row_of("TXMODE") is ROWS["TxMode"]
    assert row_of("IoCtl").name == "Ioctl"  # the manual spells it both ways


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        *[("AcceptanceMask", "0xFFFFFFFF", 0xFFFFFFFF), ("AcceptanceCode", "0X12", 0x12)],
        *[("Baudrate", "0125000", 125000), ("SPIDevice", "SPI1:", "SPI1:")],
    ],
)
def test_values_as_they_are_typed(name: str, text: str, value: int | str) -> None:
    assert ROWS[name].parsed(text) == value


@pytest.mark.parametrize("text", ["", "fast", "1e5", "-1", "0x", "1_000", "٣", "0xFFFFFFFFF", " 5"])
def test_what_is_typed_wrong(text: str) -> None:
    with pytest.raises(BadValue, match="Baudrate"):
        ROWS["Baudrate"].parsed(text)


def test_settings_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Settings().align = 3  # type: ignore[misc]


# the store


@pytest.mark.conforms("FS-03", "FS-10")
def test_without_a_file_there_is_the_pre_installed_device(empty: RegistryStore) -> None:
    assert empty.devices() == ["CID1"]
    assert empty.stored("CID1:") == {}
    assert empty.settings("CID1") == Settings()
    assert not empty.path.exists()


@pytest.mark.conforms("FS-04")
def test_settings_survive(store: RegistryStore) -> None:
    store.set("CID1", "Align", 2)
    store.set("CID1:", "baudrate", 125000)
    again = RegistryStore(store.path)
    assert again.settings("CID1").align == 2
    assert again.get("CID1", "Baudrate") == 125000
    assert again.stored("CID1") == {
        "Baudrate": 125000,
        "FriendlyName": "[candrv.CID7]\nAlign = 3",
        "Align": 2,
    }


@pytest.mark.conforms("FS-04")
def test_what_was_loaded_stays_as_it_was(store: RegistryStore) -> None:
    loaded = store.settings("CID1")
    store.set("CID1", "Baudrate", 20000)
    assert loaded.baudrate == 500000
    assert store.settings("CID1").baudrate == 20000


@pytest.mark.conforms("FS-04")
def test_a_change_touches_its_line_only(store: RegistryStore) -> None:
    store.set("CID1", "Baudrate", 125000)
    assert text_of(store) == FILE.replace("= 500000  # bit/s", "= 125000  # bit/s")
    store.set("CID1", "Align", 2)
    expected = FILE.replace("= 500000  # bit/s", "= 125000  # bit/s").replace('3"""\n', '3"""\nAlign = 2\n')
    assert text_of(store) == expected
    store.delete("CID1", "FriendlyName")
    store.delete("CID1", "FriendlyName")
    assert "FriendlyName" not in text_of(store)
    store.set("CID2", "Order", 30)
    assert "Order = 30\nDeviceArrayIndex = 1\n\n[[board]]" in text_of(store)
    assert text_of(store).endswith('kind = "picocom1"  # last line')


@pytest.mark.conforms("FS-04")
def test_nothing_changes_when_nothing_changes(store: RegistryStore) -> None:
    before = store.path.stat()
    store.set("CID1", "Baudrate", 500000)
    store.delete("CID1", "Align")
    store.install("CID1")
    assert store.path.stat().st_mtime_ns == before.st_mtime_ns
    assert store.path.stat().st_ino == before.st_ino


@pytest.mark.conforms("FS-02")
def test_devices_in_ascending_order(store: RegistryStore) -> None:
    assert store.devices() == ["CID2", "CID1"]
    store.set("CID2", "Order", 20)
    assert store.devices() == ["CID1", "CID2"]
    store.set("CID2", "Order", 21)
    assert list(store.all_settings()) == ["CID1:", "CID2:"]
    assert store.all_settings()["CID2:"].device_array_index == 1


@pytest.mark.conforms("FS-01", "FS-02")
def test_no_two_devices_have_one_name(store: RegistryStore) -> None:
    with pytest.raises(BadValue, match=r"CID1: is the name of \[candrv.CID1\] and \[candrv.CID2\]"):
        store.set("CID2", "Index", 1)
    assert text_of(store) == FILE
    store.path.write_text("[candrv.A]\n[candrv.B]\n")
    with pytest.raises(BadConfig, match="CID1:"):
        store.all_settings()


@pytest.mark.conforms("FS-04")
def test_defaults_leave_the_device_what_it_is(store: RegistryStore) -> None:
    store.set("CID2", "Align", 3)
    store.set("CID2", "Baudrate", 10000)
    store.defaults("CID2")
    assert store.stored("CID2") == {"Order": 10, "DeviceArrayIndex": 1}
    assert set(store.stored("CID2")) <= set(IDENTITY)
    store.defaults("CID1")
    assert store.settings("CID1") == Settings()
    assert "# as fast as the fans can" in text_of(store)


@pytest.mark.conforms("FS-10")
def test_installing_and_removing(empty: RegistryStore) -> None:
    empty.install()
    assert text_of(empty) == "[candrv.CID1]\n"
    empty.install("CID2:")
    assert empty.devices() == ["CID1", "CID2"]
    empty.remove("CID1:")
    empty.remove("CID2")
    assert empty.devices() == []
    with pytest.raises(BadValue, match="registered are none"):
        empty.settings("CID1")
    empty.install()
    assert empty.settings("CID1") == Settings()
    size = len(text_of(empty))
    for _ in range(3):
        empty.remove()
        empty.install()
    assert len(text_of(empty)) <= size + 1


@pytest.mark.conforms("FS-10")
def test_removing_leaves_the_rest(store: RegistryStore) -> None:
    before = others_of(store)
    store.remove("CID1")
    assert store.devices() == ["CID2"]
    assert others_of(store) == before
    assert "# the second\n[candrv.CID2]" in text_of(store)
    assert "# as fast" not in text_of(store)
    store.remove("CID2")
    assert store.devices() == []
    assert others_of(store) == before
    assert '\n[[board]]\nkind = "picocom1"  # last line' in text_of(store)


@pytest.mark.conforms("FS-01")
@pytest.mark.parametrize("name", ["cid1", "CID", "CID10:", "COM1::", "", "1CID"])
def test_only_proper_names_are_registered(name: str, store: RegistryStore) -> None:
    with pytest.raises(BadValue, match="three upper-case letters and a digit"):
        store.install(name)
    assert text_of(store) == FILE


def test_unknown_devices(store: RegistryStore) -> None:
    for call in (store.stored, store.settings, store.remove, store.defaults):
        with pytest.raises(BadValue, match="'CID5:'; registered are CID1, CID2"):
            call("CID5:")
    assert text_of(store) == FILE


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("[candrv", "canwire.toml"),
        ("candrv = 5\n", "a table for each device"),
        ("[candrv]\nCID1 = 5\n", "a table for each device"),
        ("[candrv.CID1]\nColour = 5\n", r"\[candrv.CID1\]: no registry entry 'Colour'"),
        ("[candrv.CID1]\nAlign = 4\n", r"\[candrv.CID1\]: Align = 4"),
        ("[candrv.CID1]\nAlign = true\n", "Align = True"),
        (b"\xff\n", "byte 0 is no UTF-8"),
        ("a = " + "[" * 5000, "nested|canwire.toml"),
    ],
)
def test_files_that_make_no_sense(text: str | bytes, why: str, empty: RegistryStore) -> None:
    empty.path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(BadConfig, match=why):
        empty.settings("CID1")


def test_an_impossible_entry_can_be_mended(empty: RegistryStore) -> None:
    empty.path.write_text("[candrv.CID1]\nAlign = 4 # oh\n")
    with pytest.raises(BadValue, match=r"\[candrv.CID1\]: Align = 4"):
        empty.set("CID1", "IRQ", 5)
    empty.set("CID1", "Align", 3)
    assert text_of(empty) == "[candrv.CID1]\nAlign = 3 # oh\n"


@pytest.mark.parametrize(
    "text",
    [
        "candrv = {CID1 = {Align = 1}}\n",
        "[candrv]\nCID1 = {Align = 1}\n",
        "candrv.CID1.Align = 1\n",
        "[candrv]\nCID1.Align = 1\n",
    ],
)
def test_forms_that_only_an_editor_can_change(text: str, empty: RegistryStore) -> None:
    empty.path.write_text(text)
    assert empty.get("CID1", "Align") == 1
    with pytest.raises(BadConfig, match="only an editor can change"):
        empty.set("CID1", "Align", 2)
    assert text_of(empty) == text
    assert list(empty.path.parent.iterdir()) == [empty.path]


def test_a_folder_or_file_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="No such file"):
        RegistryStore(tmp_path / "nowhere" / "canwire.toml").set("CID1", "Align", 1)
    with pytest.raises(BadConfig, match="directory"):
        RegistryStore(tmp_path).devices()


def test_line_ends_and_rights_stay(empty: RegistryStore) -> None:
    empty.path.write_bytes(b"# x\r\n[candrv.CID1]\r\nAlign = 1 # y\r\n")
    empty.path.chmod(0o640)
    empty.set("CID1", "IRQ", 5)
    empty.set("CID1", "Align", 2)
    empty.install("CID2")
    assert empty.path.read_bytes() == (
        b"# x\r\n[candrv.CID1]\r\nAlign = 2 # y\r\nIRQ = 5\r\n\r\n[candrv.CID2]\r\n"
    )
    assert empty.path.stat().st_mode & 0o777 == 0o640


def test_a_link_stays_a_link(tmp_path: Path, empty: RegistryStore) -> None:
    real = tmp_path / "real.toml"
    real.write_text("")
    empty.path.symlink_to(real)
    empty.set("CID1", "Align", 1)
    assert empty.path.is_symlink()
    assert "Align = 1" in real.read_text()


def test_a_file_changed_meanwhile_is_read_again(
    store: RegistryStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    load, calls = registry_file.load, []

    def interrupted(path: Path) -> Any:
        calls.append(path)
        if len(calls) == 2:
            path.write_text(FILE + "\n# somebody else's\n")
        return load(path)

    monkeypatch.setattr(registry_file, "load", interrupted)
    store.set("CID1", "Align", 1)
    assert "# somebody else's" in text_of(store)
    assert "\nAlign = 1\n" in text_of(store)


def _write(path: Path, device: str) -> None:
    store = RegistryStore(path)
    for value in range(20):
        store.set(device, "Debug", value)


@pytest.mark.conforms("FS-04")
def test_the_file_is_whole_at_any_moment(store: RegistryStore) -> None:
    with ProcessPoolExecutor(1) as pool:
        writing = pool.submit(_write, store.path, "CID1")
        while not writing.done():
            assert others_of(store)["bus"][0]["name"] == "can0"
        writing.result()
    assert store.get("CID1", "Debug") == 19


texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
entries = st.fixed_dictionaries(
    {},
    optional={
        "Dll": texts,
        "FriendlyName": texts,
        "Baudrate": st.integers(1, 1_000_000),
        "AcceptanceCode": st.integers(0, 0xFFFF_FFFF),
        "Align": st.integers(0, 3),
        "SPIDevice": st.tuples(st.text("AMZ", min_size=3, max_size=3), st.integers(0, 9)).map(
            "{0[0]}{0[1]}:".format
        ),
    },
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40, deadline=None)
@given(wanted=st.lists(st.tuples(st.sampled_from(["CID1", "CID2", "CID3"]), entries), max_size=3))
def test_whatever_is_set_comes_back_and_the_rest_stays(
    wanted: list[tuple[str, dict[str, Any]]], tmp_path: Path
) -> None:
    store = RegistryStore(tmp_path / "canwire.toml")
    store.path.write_text(FILE, encoding="utf-8")
    before, expected = others_of(store), {name: store.stored(name) for name in store.devices()}
    for device, table in wanted:
        if device in expected and not table:
            store.remove(device)
            del expected[device]
            continue
        store.install(device)
        expected.setdefault(device, {})
        for name, value in table.items():
            store.set(device, name, value)
            expected[device][name] = value
    assert {name: store.stored(name) for name in store.devices()} == expected
    assert others_of(store) == before
    assert text_of(store).startswith('# my world\n\n[[bus]]\nname = "can0"  # the only one\n')


FRAGMENTS = [
    "# a comment\n",
    "\n",
    '[[bus]]\nname = "a#b"\n',
    "[x]\ny = [1, # [candrv.CID1]\n 2]\n",
    '[z."candrv"]\nk = """\n[candrv.CID1]\nAlign = 3\n"""\n',
    "[q]\nl = '''\n# [candrv]\n'''\n",
    '[w]\nd = {a = 1, b = [ "]" ]}\n',
    "[candrv]\n",
    "[candrv.CID1]\nAlign = 1\n",
    '[candrv."CID2"] # q\n"Order" = 0x10 # hex\n\'IRQ\' = 1_0\n',
    '[ candrv . CID3 ]\nDll = "a\\"#b" # c\n',
    "[candrv.CID4]\n   Align   =   2   \n\tIRQ = 5\t# tab\n",
    '[candrv.CID5]\nFriendlyName = """x\\\n  # y\n"""\nAlign=0\n',
]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100, deadline=None)
@given(
    pieces=st.lists(st.sampled_from(FRAGMENTS), unique=True),
    windows=st.booleans(),
    device=st.sampled_from([f"CID{number}" for number in range(1, 7)]),
    step=st.sampled_from(["install", "remove", "set", "delete"]),
)
def test_whatever_stands_around_stays(
    pieces: list[str], windows: bool, device: str, step: str, tmp_path: Path
) -> None:
    store = RegistryStore(tmp_path / "canwire.toml")
    text = "".join(pieces).replace("\n", "\r\n" if windows else "\n")
    store.path.write_bytes(text.encode())
    before, tables = others_of(store), {name: store.stored(name) for name in store.devices()}
    if step == "install":
        store.install(device)
        tables.setdefault(device, {})
    elif device not in tables:
        with pytest.raises(BadValue, match="registered are"):
            store.set(device, "Align", 3)
    elif step == "remove":
        store.remove(device)
        del tables[device]
    elif step == "set":
        store.set(device, "Align", 3)
        tables[device]["Align"] = 3
    else:
        store.delete(device, "Align")
        tables[device].pop("Align", None)
    assert others_of(store) == before
    assert {name: store.stored(name) for name in store.devices()} == tables


# chapter 5


@pytest.mark.conforms("FS-08")
@pytest.mark.parametrize(
    ("one", "other", "fine"), [(0, 0, True), (0, 1, False), (1, 0, False), (1, 1, False)]
)
@pytest.mark.parametrize("kind", ["picocom1", "picocom2", "picocom4"])
def test_two_devices_on_one_spi_port(kind: str, one: int, other: int, fine: bool) -> None:
    first = Settings.of({"DirectInterface": one})
    second = Settings.of({"DirectInterface": other, "Index": 2})
    elsewhere = Settings.of({"DirectInterface": other, "Index": 2, "SPIDevice": "SPI1:"})
    check_spi(kind, first, [first, elsewhere])
    if fine:
        check_spi(kind, first, [second])
    else:
        with pytest.raises(InUse, match=re.escape("CID2: uses SPI3:")):
            check_spi(kind, first, [second])


@pytest.mark.conforms("FS-08")
@pytest.mark.parametrize("kind", ["picomod3", "netdcu"])
def test_other_boards_have_the_port_for_themselves(kind: str) -> None:
    direct = Settings.of({"DirectInterface": 1})
    check_spi(kind, direct, [Settings.of({"Index": 2})])
