// Which columns there are, how wide, and which of them are shown.
import { remember, remembered, word } from "/static/base/base.js";

export const COLUMNS = {
  no: { width: "8ch", number: true },
  time: { width: "15ch", number: true },
  line: { width: "17ch" },
  dir: { width: "4ch" },
  type: { width: "8ch" },
  id: { width: "9ch" },
  pid: { width: "4ch", lin: true },
  name: { width: "16ch" },
  len: { width: "4ch", number: true },
  sum: { width: "9ch", lin: true },
  count: { width: "9ch", number: true },
  cycle: { width: "10ch", number: true },
  data: { width: "minmax(24ch, 1fr)" },
};
const NARROW = ["time", "dir", "id", "count", "cycle", "data"];
const USUAL = Object.keys(COLUMNS);

/** Those that are only for LIN lines are shown while one is watched. */
export function chooseColumns(lin) {
  const usual = innerWidth < 760 ? NARROW : USUAL;
  const kept = remembered(innerWidth < 760 ? "trace.columns-narrow" : "trace.columns", usual);
  return USUAL.filter((key) => kept.includes(key) && (lin || !COLUMNS[key].lin));
}

export function templateOf(columns) {
  return columns.map((key) => COLUMNS[key].width).join(" ");
}

const place = document.getElementById("columns");
for (const key of USUAL) {
  const label = document.createElement("label");
  label.className = "check";
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = chooseColumns(true).includes(key);
  box.value = key;
  label.append(box, word(`trace.column-${key}`));
  place.append(label);
}
place.addEventListener("change", () => {
  const chosen = [...place.querySelectorAll("input:checked")].map((box) => box.value);
  remember(innerWidth < 760 ? "trace.columns-narrow" : "trace.columns", chosen);
  document.dispatchEvent(new CustomEvent("columns"));
});
