// The trace: shows the part of the server's rows that fits on the screen, by time or by identifier.
import { questions, remember, remembered, say, typing, word } from "../base/base.js";
import { rules } from "./colours.js";
import { COLUMNS, chooseColumns, leastWidth, templateOf, widen } from "./columns.js";
import { FilterField } from "./filter.js";
import { showHead } from "./head.js";
import { Known } from "./known.js";
import { LinesChosen } from "./lines.js";
import { List } from "./list.js";
import { Marks } from "./marks.js";
import { menu } from "./menu.js";
import { Names } from "./names.js";
import { Plots } from "./plots.js";
import { offerMarked, replays, save, sources } from "./logs.js";
import { record } from "./recording.js";
import { fillRow } from "./filling.js";
import { makeTexts } from "./texts.js";
import { Viewing } from "./viewing.js";

const COUNT_MS = 100;
const element = (id) => document.getElementById(id);
const state = { mode: remembered("trace.mode", "time"), columns: [], dirty: false, opening: null };
const marks = new Marks();
const names = new Names(() => columns());
let kept = { source: "", ...JSON.parse(sessionStorage.getItem("canwire.trace.kept") || "{}") };

const list = new List(element("head"), element("body"), element("window"), element("spacer"), fill, open, () => viewing.send());
const viewing = new Viewing(answered, wanted, (there) => {
  element("live").textContent = there ? "" : word("base.unreachable");
});
const { rows } = viewing;
const texts = makeTexts(viewing, names);
const byFrame = () => state.mode === "id";
const known = new Known(list, viewing, byFrame);

/** Which rows the screen needs; -1: the newest. */
function wanted() {
  const room = Math.ceil(list.room) + 2;
  if (!byFrame() && list.follow) return { at: -1, rows: room, byFrame: false };
  return { at: Math.floor(list.first) + (byFrame() ? 0 : known.gone), rows: room, byFrame: byFrame() };
}

function answered(head) {
  showHead(head, viewing.look.filter);
  if (head.lines) lines.told(head.lines);
  names.look(head.databases, viewing.lines.map((line) => line.bus));
  known.answered(head);
  if (head.found !== undefined) found(head.found);
  drawNow();
  if (state.opening !== null && rows.has(state.opening)) show(known.at(state.opening));
}

function found(place) {
  if (place < 0 || place < known.gone) {
    say(word("trace.not-found", { text: element("search").value }), true);
    return;
  }
  list.setFollow(false);
  list.count = Math.max(list.count, viewing.head.count - known.gone);
  list.select(place - known.gone, false);
}

function fill(row, index) {
  const shown = { texts, marks, columns: state.columns, signals: viewing.head?.signals, byFrame: byFrame() };
  if (index === list.selected) known.selected = known.of(index);
  fillRow(row, rows, known.placeOf(index), shown, state.paused ? 0 : (performance.now() - viewing.at) / 1000);
}

/** Something else about the rows is to be shown, in the next picture. */
function draw() {
  if (state.dirty) return;
  state.dirty = true;
  requestAnimationFrame(() => { if (state.dirty) drawNow(); });
}

/** A click meets the row that it was made for: between an answer and what is drawn there is no moment. */
function drawNow() {
  state.dirty = false;
  const { head } = viewing;
  if (!head) return;
  const shown = byFrame() ? head.count : head.count - head.gone;
  state.counting ??= setTimeout(count, COUNT_MS);
  if (element("empty").hidden === (shown === 0)) element("empty").hidden = shown > 0;
  list.show(shown);
  document.dispatchEvent(new CustomEvent("drawn", { detail: { rows, last: rows.end - 1 } }));
}

/** How many rows there are; as often as somebody can read it. */
function count() {
  state.counting = null;
  const { head } = viewing;
  element("shown").textContent = byFrame() ? head.count : head.count - head.gone;
  element("kept").textContent = head.total - head.first;
}

function columns() {
  state.columns = chooseColumns({ lin: lines.lin, byFrame: byFrame(), database: names.any });
  widths();
  list.label(state.columns.map((key) => ({ key, label: word(`trace.column-${key}`), number: COLUMNS[key].number })));
  drawNow(); // the rows of the other columns have gone
}

function widths() {
  element("grid").style.setProperty("--columns", templateOf(state.columns));
  element("grid").style.setProperty("--least", leastWidth(state.columns));
}

function setMode(mode) {
  state.mode = mode;
  remember("trace.mode", mode);
  element("mode-time").setAttribute("aria-pressed", String(mode === "time"));
  element("mode-id").setAttribute("aria-pressed", String(mode === "id"));
  list.selected = -1;
  known.selected = state.opening = null;
  list.begin(mode === "time" && !state.paused);
  rows.set(new ArrayBuffer(0), 0, 0, 0);
  columns();
  viewing.send();
}

/** A snapshot: the server keeps new rows, which are not shown before the trace continues. */
function pause(on = !state.paused) {
  showPaused(on);
  list.setFollow(!on && !byFrame());
  keep({ until: on ? viewing.head?.total ?? 0 : null });
}

function showPaused(on) {
  state.paused = on;
  element("pause").setAttribute("aria-pressed", String(on));
  element("pause").textContent = word(on ? "trace.go-on" : "trace.pause");
}

/** What this tab looks at stays when another view is visited meanwhile. */
function keep(look) {
  kept = { ...kept, ...look };
  sessionStorage.setItem("canwire.trace.kept", JSON.stringify(kept));
  viewing.change(kept);
}

function open(index) {
  const row = known.of(index);
  state.opening = known.placeOf(index); // it is opened when its row has come
  if (row) show(row);
}

const askForRow = questions();
async function show(row) {
  state.opening = null;
  const newest = askForRow();
  state.frame = row.isFrame ? { line: row.line, id: row.id } : null;
  const answer = await fetch(`/trace/row?${known.query(row)}`);
  if (!newest()) return; // another one was opened meanwhile
  if (!answer.ok) {
    say((await answer.json()).message, true);
    return;
  }
  element("opened").innerHTML = await answer.text();
  element("details").hidden = false;
  list.setFollow(false);
  const index = known.indexOf(row);
  if (index >= 0) list.select(index, false); // which may have got out of sight: the list may be lower now
}

function search(text, step) {
  if (!text.trim()) return;
  if (byFrame()) setMode("time");
  list.setFollow(false);
  const begin = list.selected < 0 ? (step > 0 ? -1 : viewing.head.count) : known.placeOf(list.selected);
  viewing.jump({ find: text, begin: Math.max(begin, -1), step });
}

const filter = new FilterField((look) => {
  list.selected = -1;
  known.selected = null;
  list.setFollow(!byFrame() && !state.paused);
  viewing.change(look);
});

element("mode-time").addEventListener("click", () => setMode("time"));
element("mode-id").addEventListener("click", () => setMode("id"));
element("pause").addEventListener("click", () => pause());
element("clear").addEventListener("click", () => {
  marks.clear();
  showPaused(false);
  list.setFollow(!byFrame());
  keep({ since: viewing.head?.total ?? 0, until: null });
});
element("search").addEventListener("keydown", (event) => {
  if (event.key === "Enter") search(event.target.value, event.shiftKey ? -1 : 1);
});
element("next-error").addEventListener("click", () => search("error", 1));
element("next-mark").addEventListener("click", () => nextMark(1));
element("save-now").addEventListener("click", () => {
  if (!lines.watched.length) say(word("trace.no-lines"), true);
  else save(viewing.look, new FormData(element("saving-form")), marks.numbers);
});
element("record").addEventListener("click", async () => {
  await record(lines.watched);
  lines.look();
});
element("close-details").addEventListener("click", () => {
  element("details").hidden = true;
  element("body").focus();
});
document.addEventListener("columns", columns);
document.addEventListener("colours", () => viewing.change({ rules: rules() }));
widen(element("head"), () => { widths(); draw(); });

const plots = new Plots(() => viewing.look.source, () => state.paused, (time) => {
  if (byFrame()) setMode("time");
  list.setFollow(false);
  viewing.jump({ time });
});
element("body").addEventListener("click", (event) => {
  const signal = event.target.closest("[data-signal]");
  const place = signal && known.placeOf(signal.closest(".trace-row").index);
  if (!signal || !rows.has(place)) return;
  plots.add({ line: rows.line(place), id: rows.idText(place), signal: signal.dataset.signal });
  event.stopPropagation();
}, { capture: true });
element("opened").addEventListener("click", (event) => {
  const signal = event.target.closest("[data-signal]");
  if (signal && state.frame) plots.add({ ...state.frame, signal: signal.dataset.signal });
});

function toggleMark(row) {
  if (!row) return;
  marks.toggle(row.number);
  draw();
}

function nextMark(step) {
  const near = marks.next(known.of(list.selected)?.number ?? -1, step);
  if (near === null) say(word("trace.no-marks"), true);
  else {
    list.setFollow(false);
    viewing.jump({ near });
  }
}

menu(element("body"), element("row-menu"), (index) => {
  list.select(index, false);
  return known.of(index);
}, (what, row) => {
  if (what === "mark") toggleMark(row);
  else if (what === "open") show(row);
  else if (row.id) {
    const part = `id:${row.id}`;
    const before = element("filter").value.trim();
    filter.set(what === "only" ? part : [before, `!${part}`].filter(Boolean).join(", "), true);
  }
}, () => list.selected);

const KEYS = {
  " ": () => pause(),
  "/": () => element("search").focus(),
  f: () => element("filter").focus(),
  o: () => setMode(byFrame() ? "time" : "id"),
  m: () => { if (list.selected >= 0) toggleMark(known.of(list.selected)); },
  n: () => nextMark(1),
  N: () => nextMark(-1),
  e: () => search("error", 1),
  E: () => search("error", -1),
};
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !element("details").hidden) element("close-details").click();
  if (typing(event) || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === " " && event.target.closest("button, a, input")) return; // presses it
  if (!(event.key in KEYS)) return;
  KEYS[event.key]();
  event.preventDefault();
});
setInterval(() => { if (byFrame()) draw(); }, 100); // changes fade, and silent identifiers are marked

if (kept.until !== undefined && kept.until !== null) showPaused(true);
const lines = new LinesChosen(element("lines"), kept.source, (addresses) => {
  columns();
  viewing.change({ lines: addresses, ...filter.look, rules: rules(), ...kept });
});
sources(kept.source, (source) => {
  kept = { source, since: 0, until: null };
  showPaused(false);
  sessionStorage.setItem("canwire.trace.kept", JSON.stringify(kept));
  lines.forget(source);
  list.begin(!byFrame() && !source);
});
replays(() => viewing.look, () => lines.channels());
element("save").addEventListener("click", () => offerMarked(marks.numbers.length));
setMode(state.mode);
