// One row for each frame: how often it came, how far apart, and what was in it before.
import { ROW_BYTES, Rows } from "/static/trace/rows.js";

const MOST = 8192; // different frames; more are not shown one by one

export class ByFrame {
  constructor(rows) {
    this.rows = rows;
    this.latest = new Rows(MOST);
    this.clear();
  }

  clear() {
    this.entries = new Map();
    this.shown = [];
  }

  take(place, passes) {
    const { rows, latest } = this;
    const key = rows.kind(place) >= 0xf0 ? null : rows.key(place);
    if (key === null) return;
    let entry = this.entries.get(key);
    const isNew = entry === undefined;
    if (isNew) {
      if (this.entries.size === MOST) return;
      entry = { slot: this.entries.size, count: 0, cycle: null, time: 0, before: null };
      this.entries.set(key, entry);
    }
    const at = rows.at(place);
    const time = rows.time(place);
    if (!isNew) {
      entry.cycle = time - entry.time;
      entry.before = latest.dataText(entry.slot);
    }
    latest.octets.set(rows.octets.subarray(at, at + ROW_BYTES), entry.slot * ROW_BYTES);
    entry.count += 1;
    entry.time = time;
    if (isNew && passes(latest, entry.slot)) this.insert(entry);
  }

  filter(passes) {
    this.shown = [...this.entries.values()].filter((entry) => passes(this.latest, entry.slot));
    this.shown.sort((one, other) => this.order(one, other));
  }

  insert(entry) {
    let low = 0;
    let high = this.shown.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.order(this.shown[middle], entry) < 0) low = middle + 1;
      else high = middle;
    }
    this.shown.splice(low, 0, entry);
  }

  order(one, other) {
    const { latest } = this;
    return latest.line(one.slot) - latest.line(other.slot) || latest.id(one.slot) - latest.id(other.slot);
  }
}
