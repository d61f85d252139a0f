// What this viewer looks at, and the rows on its screen, asked for one answer at a time: the server keeps all of them.
import { live } from "../base/base.js";
import { Rows } from "./rows.js";

const MARGIN = 40; // rows above and below the screen, for scrolling

/** `answered(head)` is called with every answer; `wanted()` says which rows the screen needs: {at, rows, byFrame}. */
export class Viewing {
  constructor(answered, wanted, reachable) {
    this.rows = new Rows();
    this.head = null;
    this.look = { number: 0, source: "", lines: [], filter: "", direction: "", rules: [], since: 0, until: null };
    this.answered = answered;
    this.wanted = wanted;
    this.labels = [];
    this.lines = [];
    this.eras = [];
    this.finding = null;
    this.at = 0; // when the last answer came
    this.socket = live("/trace/live", (data) => this.take(data), reachable, () => this.send(true));
  }

  /** Look at something else. */
  change(look) {
    this.look = { ...this.look, ...look, number: this.look.number + 1 };
    this.send(true);
  }

  /** Ask for what the screen needs now. */
  send(look = false) {
    const { at, rows, byFrame } = this.wanted();
    const first = at < 0 ? -1 : Math.max(0, at - MARGIN);
    const ask = { at: first, rows: at < 0 ? rows + MARGIN : rows + 2 * MARGIN, byFrame, ...this.finding };
    this.socket.send(look ? { look: this.look, ask } : { ask });
  }

  /** Ask for the rows about one of this number, or about the nearest one with a text. */
  jump(wanted) {
    this.finding = wanted;
    this.send();
  }

  take(buffer) {
    const length = new DataView(buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
    if (head.lines) {
      this.lines = head.lines;
      this.eras = head.eras;
      for (const line of head.lines) {
        if (line.number >= 0) this.labels[line.number] = line.bus ? `${line.bus} ${line.address}` : line.address;
      }
    }
    if (head.look !== this.look.number || head.byFrame !== this.wanted().byFrame) { // of what was asked before
      this.send();
      return;
    }
    this.rows.set(buffer, 8 + length, head.rows, head.at);
    this.head = head;
    this.at = performance.now();
    if (head.found !== undefined) this.finding = null;
    this.answered(head);
    requestAnimationFrame(() => this.send()); // a page that nobody sees asks for nothing
  }

  /** The bus of the line with this number in rows. */
  busOf(number) {
    return this.lines.find((line) => line.number === number)?.bus ?? "";
  }

  /** Nanoseconds since 1970 of the time zero that a row counts from; 0 where it is not known. */
  epoch(number) {
    let found = 0;
    for (const [first, epoch] of this.eras) if (first <= number) found = epoch;
    return found;
  }
}
