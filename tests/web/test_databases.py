"""Network descriptions opened in the page: several, by bus, of CAN and of LIN; used by every view from then on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import canwire
from canwire import BadValue, Frame, LinFrame
from canwire.web.databases.loaded import MOST, Databases
from tests.hubs import LONG_S
from tests.web.conftest import served_site, somebody
from tests.web.trace.watching import rows_with, sender, tab_on_trace, watching

pytest.importorskip("cantools")
if TYPE_CHECKING:
    import httpx2 as httpx
    from playwright.sync_api import Browser

    from canwire.web.server import Site

pytestmark = pytest.mark.conforms("PG-02")

EXAMPLES = Path(__file__).parents[2] / "examples"
CAR = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
"""
TRUCK = CAR.replace("Engine", "Diesel").replace("0.25", "0.5")


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    car, truck = tmp_path / "car.dbc", tmp_path / "truck.dbc"
    car.write_text(CAR)
    truck.write_text(TRUCK)
    return car, truck


FRAME = Frame(0x100, (4000).to_bytes(8, "little"))


def test_a_file_for_a_bus_counts_before_those_for_every_bus(files: tuple[Path, Path]) -> None:
    car, truck = files
    databases = Databases([str(car), f"can1={truck}"])
    assert databases.of("can0").name_of(FRAME) == "Engine"
    assert databases.of("can1").name_of(FRAME) == "Diesel"
    assert [one.value for one in databases.of("can1").signals(FRAME)] == ["2000"]
    assert databases.on("").messages() == ["Diesel", "Engine"]
    version = databases.version
    databases.assign(databases.loaded[1].key, "")
    assert databases.version > version
    assert databases.of("can1").name_of(FRAME) == "Engine"  # the first one counts
    databases.close(databases.loaded[0].key)
    assert databases.of("can0").name_of(FRAME) == "Diesel"


def test_what_is_not_open_and_what_is_too_much_is_refused(files: tuple[Path, Path]) -> None:
    databases = Databases([str(files[0])] * MOST)
    with pytest.raises(BadValue, match="db-77"):
        databases.close("db-77")
    with pytest.raises(BadValue, match=str(MOST)):
        databases.load(files[0])


def opened(client: httpx.Client, path: Path, bus: str = "") -> str:
    answer = client.post("/databases/open", params={"name": path.name, "bus": bus}, content=path.read_bytes())
    assert answer.status_code == 200, answer.text
    return str(answer.json()["key"])


@pytest.mark.finding("page B5")
def test_they_are_opened_chosen_and_closed_by_whoever_has_the_token(
    client: httpx.Client, viewer: httpx.Client, files: tuple[Path, Path]
) -> None:
    car, truck = files
    first, second = opened(client, car), opened(client, truck, "can1")
    record = canwire.frames_to_array([FRAME]).tobytes().hex()
    assert "Diesel" in client.get("/trace/row", params={"record": record, "bus": "can1"}).text
    names = client.get("/trace/names", params={"buses": "can0,can1"}).json()
    assert names == {
        "names": {"can0": {"100": "Engine"}, "can1": {"100": "Diesel"}},
        "files": ["car.dbc", "truck.dbc"],
    }
    assert client.post("/databases/assign", data={"key": first, "bus": "can9"}).status_code == 200
    assert client.post("/databases/close", data={"key": second}).status_code == 200
    assert [one["bus"] for one in viewer.get("/databases").json()] == ["can9"]
    assert viewer.post("/databases/close", data={"key": first}).status_code == 403


def test_a_file_that_is_no_description_is_told_by_its_name(client: httpx.Client, tmp_path: Path) -> None:
    path = tmp_path / "car.dbc"
    path.write_bytes(b"\xff\xfe\x00BO_ what")
    answer = client.post("/databases/open", params={"name": path.name}, content=path.read_bytes())
    assert answer.status_code == 409
    assert answer.json()["message"].startswith("car.dbc")
    assert client.post("/databases/open", content=b"").status_code == 422
    assert client.get("/databases").json() == []


def test_ldf_frames_have_names_and_signals_and_their_tables_run(client: httpx.Client) -> None:
    pytest.importorskip("ldfparser")
    path = next(EXAMPLES.glob("*.ldf"))
    opened(client, path, "lin0")
    network = canwire.ldf.load(path)
    frame = next(iter(network.responses(network.master).values()))
    database = canwire.load_database(path)
    names = client.get("/trace/names", params={"buses": "lin0,can0"}).json()["names"]
    described = database.message_of(frame)
    assert described is not None
    assert names["lin0"][f"{frame.id:02X}"] == described.name
    assert names["can0"] == {}
    told = client.get("/send/choices").json()
    assert {one["name"].partition(": ")[2] for one in told["tables"]} == set(network.schedules)
    assert described.name in told["messages"]["lin0"]["lin"]
    assert isinstance(frame, LinFrame)


def test_filters_know_the_signals_of_each_bus(
    site: Site, hub: canwire.Hub, client: httpx.Client, files: tuple[Path, Path]
) -> None:
    address = canwire.find_lines(hub, "can0")[0].address
    with watching(site, [address]) as viewer, sender(hub) as channel:
        for raw in (1000, 4000, 8000):
            channel.send(Frame(0x100, raw.to_bytes(8, "little")), timeout=LONG_S)
        viewer.until(lambda one: len(one.frames) == 3)
        viewer.look([address], filter="Speed > 900", number=2)
        viewer.until(lambda one: one.head["look"] == 2 and one.head["fault"])
        opened(client, files[0])
        opened(client, files[1], "can7")
        viewer.until(lambda one: not one.head["fault"])
        viewer.look([address], filter="Speed > 900", number=3)
        viewer.until(lambda one: one.head["look"] == 3 and len(one.frames) == 2)
        viewer.look([address], filter="diesel", number=4)
        viewer.until(lambda one: one.head["look"] == 4 and one.head["fault"])


def test_in_the_browser_names_come_with_the_file_and_go_with_it(
    browser: Browser, hub_address: str, hub: canwire.Hub, files: tuple[Path, Path]
) -> None:
    """Three clicks and a file: Databases, Open file, Close."""
    address = canwire.find_lines(hub, "can0")[0].address
    with (
        served_site(hub_address) as site,
        sender(hub) as channel,
        tab_on_trace(browser, site, address) as page,
    ):
        channel.send(FRAME, timeout=LONG_S)
        row = page.locator("#body .trace-row:not([hidden])")
        rows_with(page, id="100").wait_for()
        page.get_by_role("button", name="Databases").click()
        page.locator("#database-file").set_input_files(list(files))
        page.get_by_label("Bus of truck.dbc").select_option("can0")
        page.get_by_text("truck.dbc describes can0.").wait_for()
        page.get_by_role("button", name="Close", exact=True).click()
        row.filter(has_text="Diesel").wait_for()
        page.get_by_text("decoded by car.dbc, truck.dbc").wait_for()
        page.get_by_role("button", name="Databases").click()
        page.get_by_role("button", name="Close truck.dbc").click()
        page.get_by_role("button", name="Close", exact=True).click()
        row.filter(has_text="Engine").wait_for()


def test_a_row_in_the_dialog_has_the_messages_of_its_line(hub_address: str, files: tuple[Path, Path]) -> None:
    car, truck = files
    with served_site(hub_address, [f"can0={car}", f"nowhere={truck}"]) as site, somebody(site) as client:
        told = client.get("/send/choices").json()["messages"]
        assert told["can0"] == {"can": ["Engine"], "lin": []}
        assert told["lin0"] == {"can": [], "lin": []}
