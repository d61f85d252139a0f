"""`canwire plot`: what it draws of logs and lines, the page in a browser, and the examples of its help."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from xml.etree import ElementTree

import pytest

import canwire
from canwire import Frame, LinFrame, LogEntry, create_log
from canwire.commands import VERBS, main
from tests.commands.conftest import running_lines
from tests.missing import find_browser

pytest.importorskip("cantools")
pytestmark = pytest.mark.conforms("PC-10", "PF-12")

EXAMPLES = Path(__file__).parents[3] / "examples"
COUNT = 400


def engine_data(number: int, time_ns: int = 0) -> Frame:
    """EngineSpeed rises by 10 rpm a frame, Ready changes in the middle."""
    raw = (number * 40).to_bytes(2, "little") + bytes((60, number >= COUNT // 2))
    return Frame(256, raw + bytes(4), timestamp_ns=time_ns)


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log with 10 ms from frame to frame."""
    path = tmp_path_factory.mktemp("drive") / "drive.log"
    with create_log(path, dated=False) as log:
        for number in range(COUNT):
            time_ns = 5 * 10**9 + number * 10_000_000
            log.write(LogEntry(time_ns, "can0", engine_data(number, time_ns), "R"))
            log.write(LogEntry(time_ns, "can0", Frame(0x7FF, bytes(8), timestamp_ns=time_ns), "R"))
    return path


@pytest.fixture
def folder(drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """drive.log and engine.dbc."""
    monkeypatch.chdir(tmp_path)
    for path in (drive, EXAMPLES / "engine.dbc"):
        shutil.copy(path, tmp_path)
    return tmp_path


@pytest.fixture
def busy_hub(hub_address: str) -> Iterator[str]:
    """Two lines on can0; one sends EngineData every 5 ms, the other acknowledges."""
    with canwire.connect(hub_address) as hub, ExitStack() as closing:
        _, (place, _) = running_lines(hub, closing, "HW000001:0", "HW000001:1")
        scheduler = closing.enter_context(hub.open_scheduler(place.board.id, place.line))
        ticks = place.info.capabilities.cyclic
        scheduler.resume()
        record = canwire.frames_to_array([engine_data(3)]).tobytes()
        scheduler.start(scheduler.add(record, max(1, round(0.005 * ticks.clock_hz / ticks.divisor))))
        yield hub_address


def examples() -> list[str]:
    import importlib

    text = importlib.import_module(VERBS["plot"].module).__doc__ or ""
    return re.findall(r"^canwire (plot\b.*?)(?:  .*)?$", text, re.MULTILINE)


def samples(path: str = "out.html") -> dict[str, tuple[list[float], list[float]]]:
    """Of a page."""
    found = re.search(r'id="data">(.*?)</script>', Path(path).read_text(encoding="utf-8"))
    assert found is not None
    return {
        track["name"]: (track["t"], track["v"]) for panel in json.loads(found[1]) for track in panel["tracks"]
    }


def test_there_are_examples() -> None:
    assert len(examples()) >= 5


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("example", [one for one in examples() if "plot can0" not in one])
def test_the_help_s_examples(example: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    words = shlex.split(example)
    assert main(words) == 0
    assert "samples of" in capsys.readouterr().err
    head = Path(words[-1]).read_bytes()[:8]
    assert head.startswith(
        {"png": b"\x89PNG", "svg": b"<?xml", "html": b"<!DOCTYP"}[words[-1].split(".")[-1]]
    )


@pytest.mark.realtime
@pytest.mark.usefixtures("folder")
def test_a_line(busy_hub: str, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    words = shlex.split(next(one for one in examples() if "plot can0" in one))
    assert main([*words, "--seconds", "0.3", "--hub", busy_hub]) == 0
    assert "listening" in capsys.readouterr().err
    assert Path("now.svg").stat().st_size > 1000
    assert main(["plot", "can0", "--db", "engine.dbc", "EngineSpeed", "--seconds", "0.3", "-o", "out.html",
                 "--hub", busy_hub]) == 0  # fmt: skip
    times, values = samples()["EngineData.EngineSpeed"]
    assert set(values) == {30.0}
    assert 0 <= times[0] < times[-1] <= 0.3


@pytest.mark.smoke
@pytest.mark.usefixtures("folder")
def test_the_samples_are_those_of_the_log() -> None:
    assert (
        main(["plot", "drive.log", "--db", "engine.dbc", "EngineData.EngineSpeed", "Ready", "-o", "out.html"])
        == 0
    )
    found = samples()
    times, speeds = found["EngineData.EngineSpeed"]
    assert speeds == [number * 10.0 for number in range(COUNT)]
    assert times == pytest.approx([number * 0.01 for number in range(COUNT)])
    assert found["EngineData.Ready"][1] == [0.0] * (COUNT // 2) + [1.0] * (COUNT // 2)


@pytest.mark.usefixtures("folder")
def test_a_part_of_the_log() -> None:
    words = ["plot", "drive.log", "--db", "engine.dbc", "EngineSpeed", "-o", "out.html"]
    assert main([*words, "--begin", "1", "--end", "1.5", "--channel", "can0"]) == 0
    times, _ = samples()["EngineData.EngineSpeed"]
    assert (len(times), times[0], times[-1]) == (51, pytest.approx(1.0), pytest.approx(1.5))


@pytest.mark.usefixtures("folder")
def test_channels_are_named_where_there_are_several() -> None:
    with create_log("two.log", dated=False) as log:
        for number, channel in enumerate(("can0", "can1", "can0")):
            log.write(LogEntry(number, channel, engine_data(number, number), "R"))
    assert main(["plot", "two.log", "--db", "engine.dbc", "EngineSpeed", "-o", "out.html"]) == 0
    assert {name: values for name, (_, values) in samples().items()} == {
        "can0 EngineData.EngineSpeed": [0.0, 20.0],
        "can1 EngineData.EngineSpeed": [10.0],
    }


@pytest.mark.usefixtures("folder")
def test_signals_of_lin() -> None:
    pytest.importorskip("ldfparser")
    database = canwire.load_database(EXAMPLES / "door.ldf")
    with create_log("door.csv", dated=False) as log:
        for number, position in enumerate((0, 50, 100)):
            frame = database.encode("LeftState", {"LeftPosition": position}, fill=0)
            assert isinstance(frame, LinFrame)
            log.write(LogEntry(number, "lin0", LinFrame(frame.id, frame.data, timestamp_ns=number), "R"))
    assert (
        main(["plot", "door.csv", "--db", str(EXAMPLES / "door.ldf"), "LeftPosition", "-o", "out.html"]) == 0
    )
    assert samples()["LeftState.LeftPosition"] == ([0.0, 1e-9, 2e-9], [0.0, 50.0, 100.0])


@pytest.mark.usefixtures("folder")
def test_the_svg_has_names_units_texts() -> None:
    pytest.importorskip("matplotlib")
    assert main(["plot", "drive.log", "--db", "engine.dbc", "EngineSpeed", "Ready", "-o", "out.svg"]) == 0
    texts = {
        element.text for element in ElementTree.parse("out.svg").iter("{http://www.w3.org/2000/svg}text")
    }
    assert {"EngineData.EngineSpeed", "EngineData.Ready", "rpm", "s", "no", "yes"} <= texts
    one = Path("out.svg").read_bytes()
    assert main(["plot", "drive.log", "--db", "engine.dbc", "EngineSpeed", "Ready", "-o", "out.svg"]) == 0
    assert Path("out.svg").read_bytes() == one


def test_many_samples_are_thinned_to_their_extremes(monkeypatch: pytest.MonkeyPatch) -> None:
    numpy = pytest.importorskip("numpy")
    from canwire.commands.plot import tracks as tested
    from canwire.commands.plot.choosing import Label

    monkeypatch.setattr(tested, "MOST", 1000)
    label = Label("M", "S", "V", ())
    tracks = tested.Tracks([label])
    values = numpy.sin(numpy.arange(50_000) / 300)
    values[12_345], values[40_001], values[777] = 9.0, -9.0, numpy.nan
    for at in range(0, 50_000, 500):
        tracks.add(label, "can0", numpy.arange(at, at + 500) / 1e3, values[at : at + 500])
    ((track,),) = tracks.panels(100)
    assert (tracks.samples, tracks.no_numbers) == (49_999, 1)
    assert len(track.values) <= 250
    assert (track.values.max(), track.values.min()) == (9.0, -9.0)
    assert (numpy.diff(track.times_s) > 0).all()
    assert (track.times_s[-1], track.times_s[track.values.argmax()]) == (49.999, 12.345)


@pytest.mark.usefixtures("folder")
def test_faults_are_told_and_what_there_is_is_drawn(capsys: pytest.CaptureFixture[str]) -> None:
    with open("drive.log", "a") as log:
        log.write("(9.0) can0 nothing\n")
    assert main(["plot", "drive.log", "--db", "engine.dbc", "EngineData", "EEC1", "-o", "out.html"]) == 1
    said = capsys.readouterr().err
    assert f"drive.log: line {2 * COUNT + 1}: " in said
    assert "EEC1.EngSpeed: not in drive.log" in said
    assert len(samples()) == 5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["drive.log", "EngineSped", "-o", "a.html"], "did you mean EngineSpeed"),
        (
            ["drive.log", "EngineData.Sped", "-o", "a.html"],
            "EngineData.Sped: no such signal; there are EngineSpeed",
        ),
        (["drive.log", "EEC1", "-o", "a.html"], "nothing to plot: drive.log has none of EEC1"),
        (["drive.log", "EngineData", "-o", "a.gif"], "-o a.gif: .png or .svg or .html"),
        (["drive.log", "EngineData", "-o", "a.html", "--seconds", "1"], "--seconds: of a line"),
        (
            ["can7", "EngineData", "-o", "a.html", "--begin", "1"],
            "--begin: of a log, and there is no such file (can7)",
        ),
        (["drive.log", "EngineData", "-o", "a.html", "--begin", "2", "--end", "1"], "the end is after"),
        (["drive.log", "EngineData", "-o", "no/a.html"], "no/a.html"),
        (["no.log", "EngineData", "-o", "a.html"], "no.log is no log that canwire knows"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_mistakes_are_one_line(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("no.log").write_text("nothing of a log\n" * 1000)
    assert main(["plot", *words, "--db", "engine.dbc"]) == 2
    told = capsys.readouterr()
    assert said in told.err
    assert told.err.count("\n") == 1
    assert not Path("a.html").exists()


@pytest.mark.usefixtures("folder")
def test_without_matplotlib(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.delitem(sys.modules, "canwire.commands.plot.picture", raising=False)
    words = ["plot", "drive.log", "--db", "engine.dbc", "EngineSpeed", "-o"]
    assert main([*words, "out.png"]) == 2
    assert "pip install 'canwire[plot]'" in capsys.readouterr().err
    assert main([*words, "out.html"]) == 0


@pytest.mark.usefixtures("folder")
def test_the_page_in_a_browser() -> None:
    """It shows values under the pointer, zooms by dragging, and loads nothing."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = find_browser()
    assert main(["plot", "drive.log", "--db", "engine.dbc", "EngineSpeed", "Ready", "-o", "out.html"]) == 0
    asked: list[str] = []
    faults: list[str] = []
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport={"width": 1000, "height": 700})
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(Path("out.html").resolve().as_uri())
        first = page.locator("svg").first
        box = first.bounding_box()
        assert box is not None
        left, wide, middle = box["x"] + 96, box["width"] - 108, box["y"] + 100
        page.mouse.move(left + wide / 2, middle)
        at = re.search(r"EngineData\.EngineSpeed +([\d.]+) rpm +at ([\d.]+) s", first.text_content() or "")
        assert at is not None
        assert float(at[1]) == pytest.approx(1000 * float(at[2]), abs=20)  # 10 rpm in 10 ms
        assert "EngineData.Ready  " in (page.locator("svg").nth(1).text_content() or "")
        before = first.text_content()
        page.mouse.down()
        page.mouse.move(left + wide * 0.6, middle)
        page.mouse.up()
        zoomed = first.text_content()
        page.mouse.dblclick(left + wide / 2, middle)
        after = first.text_content()
        browser.close()
    assert zoomed != before
    assert (after or "").split("EngineData")[0] == (before or "").split("EngineData")[0]
    assert (faults, len(asked)) == ([], 1)
