"""Answers of a busy server come in another order than they were asked for, or when nobody wants them any more."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from canwire.web.files import static_path
from canwire.web.server import Site
from tests.web.conftest import at, tab

if TYPE_CHECKING:
    from playwright.sync_api import Browser

pytestmark = pytest.mark.conforms("N-53")

ASKING = """
    const waiting = [];
    window.fetch = (path) => new Promise((tell) => path.includes(asks) && waiting.push(tell));
    const asked = (ask) => {
        ask();
        return waiting.at(-1);
    };
    const answer = async (question, told) => {
        question({ ok: true, json: async () => told, text: async () => told });
        await new Promise((go) => setTimeout(go));
    };
    const choose = (select, name) => asked(() => {
        select.append(new Option(name));
        select.value = name;
        select.dispatchEvent(new Event("change"));
    });
"""


def seen(browser: Browser, site: Site, view: str, asks: str, story: str) -> Any:
    """What the story returns on this view, where each question to an address with `asks` in it waits for its answer."""
    with tab(browser, at(site, view)) as page:
        told = "async ([place, asks]) => {" + ASKING + story + "}"
        return page.evaluate(told, [static_path(), asks])


def test_lines_of_the_trace(browser: Browser, steady: Site) -> None:
    """The page asks for the lines every 2 s. Meanwhile a log is opened or closed, or a later answer has come."""
    story = """
        const { LinesChosen } = await import(`${place}/trace/lines.js`);
        const taken = [];
        document.addEventListener("logs", ({ detail }) => taken.push(...detail));
        const choice = document.createElement("fieldset");
        choice.append(document.createElement("legend"));
        const lines = new LinesChosen(choice, "", (addresses) => taken.push(addresses.join()));
        const about = (bus, log) => {
            const lines = [{ address: bus, bus, kind: "CAN", running: true, state: "" }];
            return { lines, logs: [log], recording: { files: [] }, replay: {} };
        };
        const ofAnother = asked(() => lines.forget("log-1"));
        const first = asked(() => lines.forget("log-2"));
        await answer(ofAnother, about("can9", "log-9"));
        await answer(first, about("can1", "log-1"));
        const slow = asked(() => lines.look());
        const quick = asked(() => lines.look());
        await answer(quick, about("can2", "log-2"));
        await answer(slow, about("can9", "log-9"));
        const closed = asked(() => lines.look());
        document.addEventListener("logs", () => lines.forget("log-4"), { once: true });
        await answer(closed, about("can9", "log-3"));
        await answer(waiting.at(-1), about("can4", "log-4"));
        return taken;
    """
    taken = seen(browser, steady, "trace", "source=log", story)
    assert taken == ["log-1", "can1", "log-2", "can2,can1", "log-3", "log-4", "can4"]


def test_names_of_frames_in_the_trace(browser: Browser, steady: Site) -> None:
    story = """
        const { Names } = await import(`${place}/trace/names.js`);
        let changes = 0;
        const names = new Names(() => { changes += 1; });
        const before = asked(() => names.look(1, ["can0"]));
        const now = asked(() => names.look(1, ["can1"]));
        await answer(now, { names: { can1: { 256: "Engine" } }, files: [] });
        await answer(before, { names: { can0: { 256: "Brake" } }, files: [] });
        return [names.of("can1", 256), names.of("can0", 256), changes];
    """
    assert seen(browser, steady, "trace", "/trace/names?buses=can", story) == ["Engine", "", 1]


def test_points_of_a_curve_in_the_trace(browser: Browser, steady: Site) -> None:
    """They are asked for twice a second, also while the first of many points have not come yet."""
    story = """
        const { Plots } = await import(`${place}/trace/plots.js`);
        const plots = new Plots(() => "", () => true, () => {});
        const first = asked(() => plots.add({ line: 0, id: "100", signal: "Speed" }));
        const second = asked(() => plots.look());
        await answer(first, { t: [1, 2], v: [10, 20], next: 2 });
        await answer(second, { t: [1, 2, 3], v: [10, 20, 30], next: 3 });
        const third = asked(() => plots.look());
        await answer(third, { t: [3], v: [30], next: 3 });
        return [plots.curves[0].t, plots.curves[0].v];
    """
    points = seen(browser, steady, "trace", "signal=Speed", story)
    assert points == [[1, 2, 3], [10, 20, 30]]


def test_samples_of_the_statistics(browser: Browser, steady: Site) -> None:
    story = """
        const plots = [];
        window.uPlot = new Proxy(uPlot, {
            construct(real, told) {
                plots.push(new real(...told));
                return plots.at(-1);
            },
        });
        document.dispatchEvent(new CustomEvent("theme")); // draws them again
        const line = document.getElementById("line");
        const look = () => line.dispatchEvent(new Event("change"));
        const sample = { columns: [[1], [7], [25], [0], [0], [0], [0], [0], [0]], epoch: 0 };
        const [first, second] = [asked(look), asked(look)];
        await answer(first, sample);
        await answer(second, sample);
        return plots[0].data.map((column) => [...column]);
    """
    assert seen(browser, steady, "statistics", "/statistics/samples", story) == [[7], [25]]


def test_signals_of_a_row_to_send(browser: Browser, steady: Site) -> None:
    """Else the fields of another message would be filled in, and sent."""
    story = """
        const { message } = document.getElementById("row-form").elements;
        const [before, now] = [choose(message, "Brake"), choose(message, "Engine")];
        await answer(now, "Speed");
        await answer(before, "Pressure");
        return document.getElementById("signals").textContent;
    """
    assert seen(browser, steady, "send", "/send/signals", story) == "Speed"


def test_signals_of_a_part_of_a_panel(browser: Browser, steady: Site) -> None:
    story = """
        const { message, signal } = document.getElementById("part-form").elements;
        const [before, now] = [choose(message, "Brake"), choose(message, "Engine")];
        await answer(now, [{ name: "Speed", minimum: 0, maximum: 5000 }]);
        await answer(before, [{ name: "Pressure", minimum: 0, maximum: 9 }]);
        return [...signal.options].map((one) => one.value);
    """
    assert seen(browser, steady, "panels", "/panels/signals", story) == ["Speed"]


def test_what_was_said_of_a_later_wish(browser: Browser, steady: Site) -> None:
    """That an earlier one was done does not cover its error; that the earlier one was not is said, however late."""
    story = """
        const { post } = await import(`${place}/base/forms.js`);
        const type = "application/json";
        const reply = async (question, ok, message) => {
            question({ ok, headers: new Headers({ "content-type": type }), json: async () => ({ message }) });
            await new Promise((go) => setTimeout(go));
            return document.getElementById("status").textContent;
        };
        const [stop, start, plug, unplug] = [1, 2, 3, 4].map(() => asked(() => post("/wish", {})));
        const told = [await reply(start, false, "no such board"), await reply(stop, true, "stopped")];
        return [...told, await reply(unplug, true, "unplugged"), await reply(plug, false, "no such kind")];
    """
    told = seen(browser, steady, "boards", "/wish", story)
    assert told == ["no such board", "no such board", "unplugged", "no such kind"]
