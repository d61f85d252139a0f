// The rows that this page keeps: a ring of the server's 88-byte rows, and what a row says in words.

export const ROW_BYTES = 88;
export const HEAD_BYTES = 32;
const DLC_LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
const KINDS = { 2: "ERR", 3: "STATE", 0x10: "ARB", 0x12: "OVR", 0xf0: "GAP", 0xf1: "LOST" };
const ERRORS = ["", "stuff", "form", "ack", "bit", "fast bit", "crc", "dlc", "other"];
const STATES = ["error active", "error warning", "error passive", "bus-off", "stopped"];
const HEX = Array.from({ length: 256 }, (_, value) => value.toString(16).toUpperCase().padStart(2, "0"));

/** A ring of `capacity` rows. Rows are named by their place since the beginning: first <= place < total. */
export class Rows {
  constructor(capacity) {
    this.capacity = capacity;
    this.octets = new Uint8Array(capacity * ROW_BYTES);
    this.view = new DataView(this.octets.buffer);
    this.total = 0;
  }

  get first() {
    return Math.max(0, this.total - this.capacity);
  }

  /** Take `count` rows that begin at `at` of a buffer. */
  push(buffer, at, count) {
    for (let done = 0; done < count;) {
      const place = this.total % this.capacity;
      const some = Math.min(count - done, this.capacity - place);
      this.octets.set(new Uint8Array(buffer, at + done * ROW_BYTES, some * ROW_BYTES), place * ROW_BYTES);
      this.total += some;
      done += some;
    }
  }

  clear() {
    this.total = 0;
  }

  at(place) {
    return (place % this.capacity) * ROW_BYTES;
  }

  kind(place) {
    return this.octets[this.at(place) + 12];
  }

  id(place) {
    return this.view.getUint32(this.at(place) + 8, true);
  }

  info(place) {
    return this.view.getUint32(this.at(place) + 12, true);
  }

  line(place) {
    return this.view.getUint16(this.at(place) + 80, true);
  }

  /** Seconds on the hub's clock. */
  time(place) {
    const at = this.at(place);
    return (this.view.getUint32(at + 4, true) * 4294967296 + this.view.getUint32(at, true)) / 1e9;
  }

  extended(place) {
    return (this.info(place) & (1 << 23)) !== 0;
  }

  sent(place) {
    return (this.info(place) & (1 << 21)) !== 0;
  }

  /** What rows of the same frame have in common. */
  key(place) {
    const info = this.info(place);
    return `${this.line(place)} ${this.id(place)} ${info & 0x00e004ff}`;
  }

  length(place) {
    const info = this.info(place);
    if (info & (1 << 22)) return 0; // a remote frame
    const code = (info >>> 16) & 15;
    return info & (1 << 10) ? DLC_LENGTHS[code] : Math.min(code, 8);
  }

  idText(place) {
    if (this.kind(place)) return "";
    return this.id(place).toString(16).toUpperCase().padStart(this.extended(place) ? 8 : 3, "0");
  }

  typeText(place) {
    const kind = this.kind(place);
    if (kind) return KINDS[kind] || `${kind}`;
    const info = this.info(place);
    if (info & (1 << 22)) return "RTR";
    if (!(info & (1 << 10))) return "CAN";
    return `FD${info & (1 << 11) ? " BRS" : ""}${info & (1 << 12) ? " ESI" : ""}`;
  }

  dlcText(place) {
    return this.kind(place) ? "" : String((this.info(place) >>> 16) & 15);
  }

  dataText(place) {
    const at = this.at(place) + 16;
    const kind = this.kind(place);
    if (kind >= 0xf0) return String(this.view.getUint32(at, true));
    if (kind) return this.eventText(place, at, kind);
    let text = "";
    for (let k = 0, count = this.length(place); k < count; k += 1) text += (k ? " " : "") + HEX[this.octets[at + k]];
    return text;
  }

  eventText(place, at, kind) {
    const bit = this.view.getInt16(at + 6, true);
    const counters = `TEC ${this.view.getUint16(at + 4, true)} REC ${this.octets[at + 3]}`;
    const where = bit >= 0 ? ` at bit ${bit}` : "";
    if (kind === 2) return `${ERRORS[this.octets[at]] || "?"} error${where}, ${counters}`;
    if (kind === 3) return `${STATES[this.octets[at + 2] & 0x7f] || "?"}, ${counters}`;
    return `${kind === 0x10 ? "arbitration lost" : "overrun"}${where}`;
  }

  /** The record in hex, as the server wants it. */
  hex(place) {
    const at = this.at(place);
    let text = "";
    for (let k = 0; k < 80; k += 1) text += HEX[this.octets[at + k]];
    return text;
  }
}
