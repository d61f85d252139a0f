// The rows that this page keeps: a ring of the server's 88-byte rows, and what a row says in words.

export const ROW_BYTES = 88;
export const HEAD_BYTES = 32;
const DLC_LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
const LIN = 0x20; // in the kind of a row of a LIN line: trace/lin.py
const KINDS = { 2: "ERR", 3: "STATE", 0x10: "ARB", 0x12: "OVR", 0xf0: "GAP", 0xf1: "LOST",
  0x21: "INFO", 0x22: "ERR", 0x23: "STATE", 0x24: "WAKE", 0x25: "SLEEP", 0x26: "OVR" };
const ERRORS = ["", "stuff", "form", "ack", "bit", "fast bit", "crc", "dlc", "other"];
const STATES = ["error active", "error warning", "error passive", "bus-off", "stopped"];
const LIN_ERRORS = ["", "bit error", "checksum error", "parity error", "no response", "sync error", "no bus", "other error", "no header after three wake-ups"];
const LIN_STATES = { 0: "operational", 1: "initialising", 2: "asleep", 4: "stopped" };
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

  lin(place) {
    return (this.kind(place) & 0xe0) === LIN;
  }

  frame(place) {
    return (this.kind(place) & ~LIN) === 0;
  }

  error(place) {
    return (this.kind(place) & ~LIN) === 2;
  }

  header(place) {
    return this.lin(place) && this.frame(place) && (this.info(place) & (1 << 27)) !== 0;
  }

  id(place) {
    const at = this.at(place);
    if (!this.lin(place)) return this.view.getUint32(at + 8, true);
    return this.frame(place) ? this.octets[at + 13] & 0x3f : this.view.getInt8(at + 25) >>> 0;
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
    return (this.info(place) & (1 << (this.lin(place) ? 25 : 21))) !== 0;
  }

  /** What rows of the same frame have in common. */
  key(place) {
    const info = this.info(place);
    return `${this.line(place)} ${this.id(place)} ${info & (this.lin(place) ? 0x080000ff : 0x00e004ff)}`;
  }

  length(place) {
    const info = this.info(place);
    if (this.lin(place)) return this.header(place) ? 0 : Math.min((info >>> 16) & 0xff, 8);
    if (info & (1 << 22)) return 0; // a remote frame
    const code = (info >>> 16) & 15;
    return info & (1 << 10) ? DLC_LENGTHS[code] : Math.min(code, 8);
  }

  idText(place) {
    if (this.lin(place)) return this.id(place) < 64 ? HEX[this.id(place)] : "";
    if (this.kind(place)) return "";
    return this.id(place).toString(16).toUpperCase().padStart(this.extended(place) ? 8 : 3, "0");
  }

  typeText(place) {
    if (this.lin(place) && this.frame(place)) return this.header(place) ? "HEADER" : "LIN";
    const kind = this.kind(place);
    if (kind) return KINDS[kind] || `${kind}`;
    const info = this.info(place);
    if (info & (1 << 22)) return "RTR";
    if (!(info & (1 << 10))) return "CAN";
    return `FD${info & (1 << 11) ? " BRS" : ""}${info & (1 << 12) ? " ESI" : ""}`;
  }

  dlcText(place) {
    return this.frame(place) ? String((this.info(place) >>> 16) & 15) : "";
  }

  /** The protected identifier as it stands on a LIN bus. */
  pidText(place) {
    return this.lin(place) && this.frame(place) ? HEX[this.octets[this.at(place) + 13]] : "";
  }

  /** Of a LIN frame: its checksum, C for classic, E for enhanced. */
  checksumText(place) {
    if (!this.lin(place) || !this.frame(place) || this.header(place)) return "";
    return `${HEX[this.octets[this.at(place) + 24]]} ${this.info(place) & (1 << 24) ? "E" : "C"}`;
  }

  dataText(place) {
    const at = this.at(place) + 16;
    const kind = this.kind(place);
    if (kind >= 0xf0) return String(this.view.getUint32(at, true));
    if (!this.frame(place)) return this.lin(place) ? this.linEventText(at, kind) : this.eventText(place, at, kind);
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

  linEventText(at, kind) {
    if (kind === 0x22) return LIN_ERRORS[this.octets[at]] || "?";
    if (kind === 0x23) return LIN_STATES[this.octets[at + 8] & 0x7f] || "?";
    return { 0x24: "wake-up", 0x25: "go to sleep" }[kind] || "";
  }

  /** The record in hex, as the server wants it. */
  hex(place) {
    const at = this.at(place);
    let text = "";
    for (let k = 0; k < 80; k += 1) text += HEX[this.octets[at + k]];
    return text;
  }
}
