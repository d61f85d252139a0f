// Which columns there are, how wide, and which of them are shown.
import { remember, remembered, word } from "../base/base.js";

export const COLUMNS = {
  no: { width: "8ch", number: true, extra: true },
  time: { width: "13ch", number: true },
  wall: { width: "16ch", number: true, extra: true },
  delta: { width: "12ch", number: true, extra: true },
  line: { width: "16ch" },
  dir: { width: "3ch" },
  type: { width: "6ch" },
  id: { width: "8ch" },
  name: { width: "minmax(8ch, 14ch)", least: 8 },
  len: { width: "4ch", number: true },
  data: { width: "minmax(24ch, 1fr)", least: 24 },
  count: { width: "8ch", number: true, frame: true },
  cycle: { width: "11ch", number: true, frame: true },
  jitter: { width: "9ch", number: true, frame: true },
  signals: { width: "minmax(30ch, 2fr)", least: 30, frame: true, database: true },
  pid: { width: "4ch", lin: true },
  sum: { width: "8ch", lin: true },
};
const NARROW = ["time", "dir", "id", "data", "count", "cycle"];
const ALL = Object.keys(COLUMNS);
const USUAL = ALL.filter((key) => !COLUMNS[key].extra);
const widths = remembered("trace.widths", {}); // in pixels, of columns that were drawn wider or narrower

const narrow = () => innerWidth < 760;
const slot = () => (narrow() ? "trace.columns-narrow" : "trace.columns");

/** Those that are only for LIN lines are shown while one is watched, some by identifier alone. */
export function chooseColumns({ lin, byFrame, database }) {
  const kept = remembered(slot(), narrow() ? NARROW : USUAL);
  return ALL.filter((key) => {
    const column = COLUMNS[key];
    if (byFrame && (key === "delta" || (narrow() && ["time", "dir"].includes(key)))) return false;
    return kept.includes(key) && (lin || !column.lin) && (byFrame || !column.frame) && (database || !column.database);
  });
}

export function templateOf(columns) {
  return columns.map((key) => (widths[key] ? `${widths[key]}px` : COLUMNS[key].width)).join(" ");
}

/** What the columns need: a narrower screen is scrolled sideways, so that nothing is cut off. */
export function leastWidth(columns) {
  const parts = columns.map((key) => (widths[key] ? `${widths[key]}px` : COLUMNS[key].least ? `${COLUMNS[key].least}ch` : COLUMNS[key].width));
  return `calc(${parts.join(" + ")} + ${12 * columns.length + 24}px)`;
}

/** The right edge of a column's head is drawn; two clicks on it take the usual width again. */
export function widen(head, changed) {
  const edge = (event) => {
    const cell = event.target.closest("[data-key]");
    return cell && cell.getBoundingClientRect().right - event.clientX < 8 ? cell : null;
  };
  head.addEventListener("pointerdown", (event) => {
    const cell = edge(event);
    if (!cell) return;
    const begin = event.clientX - cell.offsetWidth;
    head.setPointerCapture(event.pointerId);
    const move = (moved) => {
      widths[cell.dataset.key] = Math.max(24, Math.round(moved.clientX - begin));
      changed();
    };
    head.addEventListener("pointermove", move);
    head.addEventListener("pointerup", () => {
      head.removeEventListener("pointermove", move);
      remember("trace.widths", widths);
    }, { once: true });
  });
  head.addEventListener("dblclick", (event) => {
    const cell = edge(event);
    if (!cell) return;
    delete widths[cell.dataset.key];
    remember("trace.widths", widths);
    changed();
  });
}

const place = document.getElementById("columns");
const chosen = remembered(slot(), narrow() ? NARROW : USUAL);
for (const key of ALL) {
  const label = document.createElement("label");
  label.className = "check";
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = chosen.includes(key);
  box.value = key;
  label.append(box, word(`trace.column-${key}`));
  place.append(label);
}
place.addEventListener("change", () => {
  const chosen = [...place.querySelectorAll("input:checked")].map((box) => box.value);
  remember(slot(), chosen);
  document.dispatchEvent(new CustomEvent("columns"));
});
