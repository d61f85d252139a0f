// What is known of rows, wherever they are now: by time the oldest go, by identifier a new one moves those below it.

import { hex } from "./rows.js";

export class Known {
  /** Of the rows of `viewing`, which `list` shows; `byFrame()` says whether they are by identifier. */
  constructor(list, viewing, byFrame) {
    Object.assign(this, { list, viewing, byFrame });
    this.gone = 0; // oldest rows by time
    this.selected = null;
  }

  /** The place of the index-th row of the list: by time it never changes. */
  placeOf(index) {
    return this.byFrame() ? index : index + this.gone;
  }

  /** Where a row is in the list; -1: it is gone, or by identifier out of sight. */
  indexOf(row) {
    return this.byFrame() ? this.viewing.rows.find(row.key) : Math.max(-1, row.place - this.gone);
  }

  /** What is known of a row in sight, or of the selected one, which may have gone out of sight meanwhile; else null. */
  of(index) {
    const place = this.placeOf(index);
    if (this.viewing.rows.has(place)) return this.at(place);
    return this.selected?.place === place ? this.selected : null;
  }

  /** Of a row in sight. */
  at(place) {
    const { rows } = this.viewing;
    return { place, key: rows.key(place), line: rows.line(place), number: rows.number(place), id: rows.idText(place),
      kind: rows.kind(place), isFrame: rows.frame(place), record: rows.record(place) };
  }

  /** What the server wants to know to describe a row. */
  query(row) {
    const { look } = this.viewing;
    const query = new URLSearchParams({ record: hex(row.record), source: look.source, bus: this.viewing.busOf(row.line) });
    if (row.kind === 2 && !this.byFrame()) query.set("number", row.number);
    return query;
  }

  /** Another answer has come. The selected row stays selected wherever it moves; if that is out of sight, none is. */
  answered(head) {
    const dropped = head.gone - this.gone;
    this.gone = head.gone;
    if (!this.byFrame()) {
      if (dropped > 0) this.list.dropped(dropped);
    } else if (this.selected && this.viewing.rows.has(this.list.selected)) this.list.selected = this.indexOf(this.selected);
  }
}
