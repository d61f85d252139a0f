// The texts of a row's cells.
import { decimal, localised, word } from "../base/base.js";

const SILENT_S = 2;
const FRESH = 100; // hundredths of a second for which a changed byte can be seen

export function clock(nanoseconds, digits = 6) {
  const milliseconds = Math.floor(nanoseconds / 1e6);
  const moment = new Date(milliseconds);
  const part = (number, width = 2) => String(number).padStart(width, "0");
  const micros = Math.floor(nanoseconds / 1000) % 1_000_000;
  const text = `${part(moment.getHours())}:${part(moment.getMinutes())}:${part(moment.getSeconds())}`;
  return digits ? `${text}.${part(micros, 6).slice(0, digits)}` : text;
}

export function makeTexts(viewing, names) {
  const { rows } = viewing;
  return {
    no: (place) => String(rows.number(place)),
    time: (place) => decimal(rows.time(place), 6),
    wall: (place) => {
      const epoch = viewing.epoch(rows.number(place));
      return epoch ? clock(epoch + rows.time(place) * 1e9) : "";
    },
    delta: (place) => (rows.has(place - 1) ? decimal(rows.time(place) - rows.time(place - 1), 6) : ""),
    line: (place) => viewing.labels[rows.line(place)] || "",
    dir: (place) => (!rows.frame(place) ? "" : rows.sent(place) ? "Tx" : "Rx"),
    type: (place) => rows.typeText(place),
    id: (place) => rows.idText(place),
    pid: (place) => rows.pidText(place),
    name: (place) => (!rows.frame(place) ? "" : names.of(viewing.busOf(rows.line(place)), rows.idText(place))),
    len: (place) => rows.dlcText(place),
    sum: (place) => rows.checksumText(place),
    data: (place) => rows.dataText(place),
  };
}

/** Columns that are there by identifier alone; `age` is in seconds since the answer. */
export function frameText(key, extra, age) {
  if (key === "count") return String(extra.count);
  if (key === "cycle") {
    const silent = extra.silent + age;
    if (extra.mean > 0 && silent > SILENT_S && silent > extra.mean / 200) return word("trace.silent", { seconds: Math.floor(silent) });
    return extra.cycle > 0 ? decimal(extra.cycle, 1) : "";
  }
  if (key === "jitter") return extra.most > 0 ? decimal(extra.most - extra.least, 1) : "";
  return "";
}

export function isSilent(extra, age) {
  return extra.mean > 0 && extra.silent + age > Math.max(SILENT_S, extra.mean / 200);
}

/** Bytes that have changed within a second stand out, and fade. */
export function markBytes(cell, text, changed, age) {
  const octets = text ? text.split(" ") : [];
  const steps = octets.map((_, k) => {
    const passed = changed[k] === 255 ? FRESH : changed[k] + age * 100;
    return passed >= FRESH ? 0 : 5 - Math.floor((passed * 5) / FRESH);
  });
  const key = `${text} ${steps.join("")}`;
  if (cell.marked === key) return;
  cell.marked = key;
  cell.replaceChildren(...octets.flatMap((octet, k) => {
    const shown = document.createElement(steps[k] ? "b" : "span");
    if (steps[k]) shown.className = `fresh-${steps[k]}`;
    shown.textContent = octet;
    return k ? [" ", shown] : [shown];
  }));
}

const seen = new Map(); // "row signal": [text, when it changed]

/** "Speed 1000 rpm" for each signal; changed ones are marked as bytes are. */
export function markSignals(cell, key, signals) {
  const now = performance.now();
  const parts = signals.map(([name, text]) => {
    const place = `${key} ${name}`;
    const before = seen.get(place);
    if (!before || before[0] !== text) seen.set(place, [text, before ? now : -Infinity]);
    const passed = (now - seen.get(place)[1]) / 10;
    return [name, text, passed >= FRESH ? 0 : 5 - Math.floor((passed * 5) / FRESH)];
  });
  const drawn = parts.join();
  if (cell.marked === drawn) return;
  cell.marked = drawn;
  cell.title = parts.map(([name, text]) => `${name} ${localised(text)}`).join("\n"); // all of them, where the column has no room
  const names = parts.map(([name]) => name).join();
  if (cell.names !== names || cell.children.length !== parts.length) {
    cell.names = names;
    cell.replaceChildren(...parts.flatMap(([name], k) => {
      const signal = document.createElement("button");
      signal.type = "button";
      signal.tabIndex = -1;
      signal.dataset.signal = name;
      return k ? [" ", signal] : [signal];
    }));
  }
  parts.forEach(([name, text, step], k) => { // the same buttons, so that a click on one is not lost when it changes
    const signal = cell.children[k];
    signal.className = `signal${step ? ` fresh-${step}` : ""}`;
    signal.textContent = `${name} ${localised(text)}`;
  });
}
