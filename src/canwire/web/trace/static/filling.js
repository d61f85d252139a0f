// A row element's cells: only changed cells are touched, since the browser lays out and paints each touched cell again.
import { frameText, isSilent, markBytes, markSignals } from "./texts.js";

/** Another text of a cell; false where it is the same. */
function put(cell, text) {
  if (!cell.marked && cell.text === text) return false;
  if (cell.marked || cell.firstChild === null) cell.textContent = text;
  else cell.firstChild.data = text; // costs less than another node
  cell.marked = "";
  cell.text = text;
  return true;
}

function dress(row, look) {
  if (row.look !== look) row.className = row.look = look;
}

/** The row at this place; `age` is in seconds since its answer came. Without `byFrame` it is one by time. */
export function fillRow(row, rows, place, { texts, marks, columns, signals, byFrame }, age) {
  if (!rows.has(place)) {
    dress(row, "trace-row coming");
    for (const cell of row.children) put(cell, "");
    return;
  }
  const event = !rows.frame(place);
  const extra = byFrame ? rows.extra(place) : null;
  const colour = rows.colour(place);
  dress(row, `trace-row${event ? ` event kind-${rows.kind(place)}` : ""}${colour ? ` tint-${colour}` : ""}`
    + `${marks.has(rows.number(place)) ? " marked" : ""}${rows.flags(place) & 1 ? " late" : ""}`
    + `${extra && isSilent(extra, age) ? " silent" : ""}`);
  columns.forEach((key, at) => {
    const cell = row.children[at];
    if (extra && key === "data" && !event) markBytes(cell, texts.data(place), extra.changed, age);
    else if (extra && key === "signals") markSignals(cell, `${rows.line(place)} ${rows.idText(place)}`, signals[place - rows.first]);
    else {
      const text = key in texts ? texts[key](place) : frameText(key, extra, age);
      if (put(cell, text) && key === "data") cell.title = event ? text : ""; // words may be longer than their column
    }
  });
}
