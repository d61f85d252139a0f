// Rows of 88 bytes as the server sends them, and what a row says in words.

import { decimal, word } from "../base/base.js";

export const ROW_BYTES = 88;
const RECORD_BYTES = 80;
const EXTRA_BYTES = 96;
const GAP = 0xf0, LOST = 0xf1, UNHEARD = 0xf2;
const DLC_LENGTHS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];
const LIN = 0x20; // in the kind of a row of a LIN line: trace/lin.py
const KINDS = { 2: "ERR", 3: "STATE", 0x10: "ARB", 0x12: "OVR", [GAP]: "GAP", [LOST]: "LOST", [UNHEARD]: "GAP",
  0x21: "INFO", 0x22: "ERR", 0x23: "STATE", 0x24: "WAKE", 0x25: "SLEEP", 0x26: "OVR" };
const ERRORS = ["", "stuff", "form", "ack", "bit", "fast-bit", "crc", "dlc", "other"];
const STATES = ["error-active", "error-warning", "error-passive", "bus-off", "stopped"];
const LIN_ERRORS = ["none", "bit", "chksum", "parity", "slnore", "sync", "nobus", "other", "wakeup"];
const LIN_STATES = { 0: "operational", 1: "initialising", 2: "asleep", 4: "stopped" };
const HEX = Array.from({ length: 256 }, (_, value) => value.toString(16).toUpperCase().padStart(2, "0"));

/** Bytes as the server wants them. */
export function hex(octets) {
  return Array.from(octets, (octet) => HEX[octet]).join("");
}

function seconds(milliseconds) {
  return decimal(milliseconds / 1000, 1);
}

/** The rows that an answer brought: places `first` to `end` of what the viewer shows, and by identifier their extras. */
export class Rows {
  constructor() {
    this.set(new ArrayBuffer(0), 0, 0, 0);
  }

  /** Take `count` rows that begin at `at` of a buffer and are at place `first`. */
  set(buffer, at, count, first) {
    this.octets = new Uint8Array(buffer, at);
    this.view = new DataView(buffer, at);
    this.first = first;
    this.end = first + count;
    this.extras = count * ROW_BYTES;
  }

  has(place) {
    return place >= this.first && place < this.end;
  }

  at(place) {
    return (place - this.first) * ROW_BYTES;
  }

  flags(place) {
    return this.octets[this.at(place) + 82];
  }

  colour(place) {
    return this.octets[this.at(place) + 83];
  }

  number(place) {
    return this.view.getUint32(this.at(place) + 84, true);
  }

  /** Of a row by identifier: answers.py's EXTRA. */
  extra(place) {
    const at = this.extras + (place - this.first) * EXTRA_BYTES;
    const real = (offset) => this.view.getFloat32(at + offset, true);
    return {
      count: this.view.getFloat64(at, true), cycle: real(8), least: real(12), most: real(16), mean: real(20),
      silent: real(24), changed: this.octets.subarray(at + 32, at + EXTRA_BYTES),
    };
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

  /** Equal for rows of one frame, as by identifier: identifiers.py's `_keys`. */
  key(place) {
    const format = this.info(place) & (this.lin(place) ? 1 << 27 : 7 << 21 | 1 << 10);
    return [this.line(place), this.kind(place), this.id(place), format].join();
  }

  /** The place of the row with this key; -1 if it is none of these. */
  find(key) {
    for (let place = this.first; place < this.end; place += 1) if (this.key(place) === key) return place;
    return -1;
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

  /** The protected identifier as sent on a LIN bus. */
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
    if (kind >= GAP) return this.markText(kind, this.view.getUint32(at, true));
    if (!this.frame(place)) return this.lin(place) ? this.linEventText(at, kind) : this.eventText(place, at, kind);
    let text = "";
    for (let k = 0, count = this.length(place); k < count; k += 1) text += (k ? " " : "") + HEX[this.octets[at + k]];
    return text;
  }

  markText(kind, count) {
    if (kind === GAP) return word("trace.gap", { seconds: seconds(count) });
    if (kind === UNHEARD) return word("trace.unheard", { seconds: seconds(count) });
    return word("trace.lost-row", { count });
  }

  eventText(place, at, kind) {
    const bit = this.view.getInt16(at + 6, true);
    const counters = `TEC ${this.view.getUint16(at + 4, true)} REC ${this.octets[at + 3]}`;
    const where = bit >= 0 ? ` ${word("trace.where", { bit })}` : "";
    if (kind === 2) return `${word(`trace.error-${ERRORS[this.octets[at]] || "other"}`)}${where}, ${counters}`;
    if (kind === 3) return `${word(`boards.state-${STATES[this.octets[at + 2] & 0x7f] || "stopped"}`)}, ${counters}`;
    return word(kind === 0x10 ? "trace.arbitration-lost" : "trace.overrun") + where;
  }

  linEventText(at, kind) {
    if (kind === 0x22) return word(`trace.lin-error-${LIN_ERRORS[this.octets[at]] || "other"}`);
    if (kind === 0x23) return word(`boards.state-lin-${LIN_STATES[this.octets[at + 8] & 0x7f] || "stopped"}`);
    return { 0x24: word("trace.wake-up"), 0x25: word("trace.go-to-sleep") }[kind] || "";
  }

  /** A copy of a row's record. */
  record(place) {
    const at = this.at(place);
    return this.octets.slice(at, at + RECORD_BYTES);
  }
}
