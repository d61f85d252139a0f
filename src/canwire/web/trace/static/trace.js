// The trace: rows from the server into a ring, what passes the filter into a list, forty row elements on the screen.
import { live, remember, remembered, say, typing, word } from "/static/base/base.js";
import { ByFrame } from "/static/trace/byframe.js";
import { COLUMNS, chooseColumns, templateOf } from "/static/trace/columns.js";
import { rules } from "/static/trace/colours.js";
import { compile } from "/static/trace/filter.js";
import { LinesChosen } from "/static/trace/lines.js";
import { List } from "/static/trace/list.js";
import { record } from "/static/trace/recording.js";
import { HEAD_BYTES, Rows } from "/static/trace/rows.js";

const KEPT = 100_000; // rows in this page: 9 MB
const BACKLOG = 5_000; // rows of the past, when the page is opened

const element = (id) => document.getElementById(id);
const rows = new Rows(KEPT);
const state = {
  mode: remembered("trace.mode", "time"), filter: null, names: {}, labels: [], places: [], start: 0,
  paused: null, columns: chooseColumns(false), lin: false, dirty: false,
};
const byFrame = new ByFrame(rows);

const list = new List(element("head"), element("body"), element("spacer"), [], fill, open);

function passes(from, place) {
  const direction = element("direction").value;
  if (direction && from.frame(place) && (direction === "T") !== from.sent(place)) return false;
  return !state.filter || state.filter(from, place);
}

function count() {
  if (state.mode === "id") return byFrame.shown.length;
  if (state.paused === null) return state.places.length - state.start;
  return Math.max(0, state.paused - state.start);
}

/** The rows to look at and the place there of the index-th one that is shown. */
function placeOf(index) {
  return state.mode === "id" ? [byFrame.latest, byFrame.shown[index].slot] : [rows, state.places[state.start + index]];
}

const TEXTS = {
  no: (from, place) => String(from.view.getUint32(from.at(place) + 84, true)),
  time: (from, place) => (from.kind(place) >= 0xf0 ? "" : from.time(place).toFixed(6)),
  line: (from, place) => state.labels[from.line(place)] || "",
  dir: (from, place) => (!from.frame(place) ? "" : from.sent(place) ? "Tx" : "Rx"),
  type: (from, place) => from.typeText(place),
  id: (from, place) => from.idText(place),
  pid: (from, place) => from.pidText(place),
  name: (from, place) => (!from.frame(place) ? "" : state.names[from.idText(place)] || ""),
  len: (from, place) => from.dlcText(place),
  sum: (from, place) => from.checksumText(place),
  data: (from, place) => from.dataText(place),
};

function fill(row, index) {
  const [from, place] = placeOf(index);
  const kind = from.kind(place);
  const event = !from.frame(place);
  const colour = rules.colourOf(from, place);
  row.className = `trace-row${event ? ` event kind-${kind}` : ""}${colour ? ` tint-${colour}` : ""}`;
  const entry = state.mode === "id" ? byFrame.shown[index] : null;
  state.columns.forEach((key, at) => {
    const cell = row.children[at];
    if (entry && key === "count") cell.textContent = entry.count;
    else if (entry && key === "cycle") cell.textContent = entry.cycle === null ? "" : (entry.cycle * 1000).toFixed(1);
    else if (entry && key === "data" && !event) mark(cell, TEXTS.data(from, place), entry.before);
    else cell.textContent = key in TEXTS ? TEXTS[key](from, place) : "";
  });
}

/** The bytes that differ from those before stand out. */
function mark(cell, text, before) {
  if (before === null || before === text) {
    cell.textContent = text;
    return;
  }
  const old = before.split(" ");
  cell.replaceChildren(...text.split(" ").flatMap((octet, k) => {
    const shown = document.createElement(octet === old[k] ? "span" : "b");
    shown.textContent = octet;
    return k ? [" ", shown] : [shown];
  }));
}

function take(buffer) {
  const head = new DataView(buffer);
  const arrived = head.getUint32(4, true);
  element("skipped").textContent = head.getFloat64(8, true);
  element("lost").textContent = head.getFloat64(16, true);
  for (const id of ["skipped", "lost"]) element(id).parentElement.classList.toggle("bad", element(id).textContent !== "0");
  const from = rows.total;
  rows.push(buffer, HEAD_BYTES, arrived);
  for (let place = from; place < rows.total; place += 1) {
    byFrame.take(place, passes);
    if (passes(rows, place)) state.places.push(place);
  }
  drop();
  draw();
}

/** Forget places whose rows were overwritten. */
function drop() {
  let gone = 0;
  while (state.start < state.places.length && state.places[state.start] < rows.first) {
    state.start += 1;
    gone += 1;
  }
  if (gone && state.mode === "time") list.dropped(gone);
  if (state.start > KEPT) {
    state.places.splice(0, state.start);
    if (state.paused !== null) state.paused -= state.start;
    state.start = 0;
  }
}

function draw() {
  if (state.dirty) return;
  state.dirty = true;
  requestAnimationFrame(() => {
    state.dirty = false;
    const shown = count();
    element("shown").textContent = shown;
    element("kept").textContent = rows.total - rows.first;
    element("empty").hidden = shown > 0;
    if (state.paused !== null && state.mode === "id") return;
    list.show(shown);
    document.dispatchEvent(new CustomEvent("drawn", { detail: { rows, total: rows.total } }));
  });
}

function again() {
  state.places = [];
  state.start = 0;
  if (state.paused !== null) pause();
  for (let place = rows.first; place < rows.total; place += 1) if (passes(rows, place)) state.places.push(place);
  byFrame.filter(passes);
  list.setFollow(state.mode === "time");
  draw();
}

function columns() {
  state.columns = chooseColumns(state.lin);
  const shown = state.columns.filter((key) => state.mode === "id" || !["count", "cycle"].includes(key));
  state.columns = shown;
  element("grid").style.setProperty("--columns", templateOf(shown));
  list.label(shown.map((key) => ({ key, label: word(`trace.column-${key}`), number: COLUMNS[key].number })));
}

function setMode(mode) {
  state.mode = mode;
  remember("trace.mode", mode);
  element("mode-time").setAttribute("aria-pressed", String(mode === "time"));
  element("mode-id").setAttribute("aria-pressed", String(mode === "id"));
  list.selected = -1;
  element("body").scrollTop = 0;
  columns();
  again();
}

function pause() {
  state.paused = state.paused === null ? state.places.length : null;
  const on = state.paused !== null;
  element("pause").setAttribute("aria-pressed", String(on));
  element("pause").textContent = word(on ? "trace.go-on" : "trace.pause");
  list.setFollow(!on && state.mode === "time");
  draw();
}

async function open(index) {
  const [from, place] = placeOf(index);
  const query = new URLSearchParams({ record: from.hex(place) });
  const following = from.kind(place) === 2 && from === rows ? nextFrame(place) : null;
  if (following !== null) query.set("following", rows.hex(following));
  const answer = await fetch(`/trace/row?${query}`);
  if (!answer.ok) {
    say((await answer.json()).message, true);
    return;
  }
  element("opened").innerHTML = await answer.text();
  element("details").hidden = false;
  list.setFollow(false);
  list.select(index, false); // which may have got out of sight: the list is lower now
}

/** The frame that was repeated after an error: the next one of the same line. */
function nextFrame(place) {
  for (let next = place + 1; next < rows.total; next += 1) {
    if (rows.frame(next) && rows.line(next) === rows.line(place)) return next;
  }
  return null;
}

function search(step) {
  const wanted = element("search").value.replace(/\s+/g, "").toLowerCase();
  const total = count();
  if (!wanted || !total) return;
  const begin = list.selected < 0 ? (step > 0 ? -1 : total) : list.selected;
  for (let k = 1; k <= total; k += 1) {
    const index = (((begin + step * k) % total) + total) % total;
    const [from, place] = placeOf(index);
    const text = `${TEXTS.id(from, place)} ${TEXTS.name(from, place)} ${TEXTS.data(from, place).replace(/ /g, "")}`;
    if (text.toLowerCase().includes(wanted)) {
      list.setFollow(false);
      list.select(index, false);
      return;
    }
  }
  say(word("trace.not-found", { text: element("search").value }), true);
}

function setFilter() {
  const field = element("filter");
  try {
    state.filter = compile(field.value, state.names);
    field.removeAttribute("aria-invalid");
    element("filter-fault").textContent = "";
    remember("trace.filter", field.value);
    again();
  } catch (part) {
    if (typeof part !== "string") throw part;
    field.setAttribute("aria-invalid", "true");
    element("filter-fault").textContent = word("trace.bad-filter", { part });
  }
}

element("mode-time").addEventListener("click", () => setMode("time"));
element("mode-id").addEventListener("click", () => setMode("id"));
element("pause").addEventListener("click", pause);
element("clear").addEventListener("click", () => {
  rows.clear();
  byFrame.clear();
  again();
});
element("direction").value = remembered("trace.direction", "");
element("direction").addEventListener("change", (event) => {
  remember("trace.direction", event.target.value);
  again();
});
element("filter").value = remembered("trace.filter", "");
element("filter").addEventListener("change", setFilter);
element("search").addEventListener("keydown", (event) => {
  if (event.key === "Enter") search(event.shiftKey ? -1 : 1);
});
element("save").addEventListener("click", () => {
  if (!lines.watched.length) say(word("trace.no-lines"), true);
  else location.assign(`/trace/log?${new URLSearchParams({ lines: lines.watched.join(","), errors: "true" })}`);
});
element("record").addEventListener("click", async () => {
  await record(lines.watched);
  lines.look();
});
element("close-details").addEventListener("click", () => {
  element("details").hidden = true;
  element("body").focus();
});
document.addEventListener("columns", () => { columns(); draw(); });
document.addEventListener("colours", draw);
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && !element("details").hidden) element("close-details").click();
  if (typing(event) || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === " " && event.target.closest("button, a")) return; // presses it
  if (event.key === " ") pause();
  else if (event.key === "/") element("search").focus();
  else if (event.key === "o") setMode(state.mode === "time" ? "id" : "time");
  else return;
  event.preventDefault();
});

let backlog = BACKLOG;
const socket = live(
  "/trace/live",
  (data) => {
    if (data instanceof ArrayBuffer) take(data);
    else lines.told(JSON.parse(data).lines, state.labels, draw);
  },
  (there) => { element("live").textContent = there ? "" : word("base.unreachable"); },
  () => watch(lines.watched),
);

function watch(addresses) {
  if (lines.lin !== state.lin) {
    state.lin = lines.lin;
    columns();
    draw();
  }
  socket.send({ watch: addresses, backlog });
  if (addresses.length) backlog = 0;
}

const lines = new LinesChosen(element("lines"), watch, (names) => {
  state.names = names;
  rules.named(names);
  setFilter();
});
setMode(state.mode);
setFilter();
