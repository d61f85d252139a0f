// Which lines are watched: those that were chosen, else one of each bus, one that runs if there is one.
import { remember, remembered, word } from "../base/base.js";
import { busesAre } from "../databases/databases.js";

const LOOK_MS = 2000;
const MOST_SAID = 3; // lines of which it is said why nothing comes
const MANY = 24; // lines; they are searched and ordered by bus then

export class LinesChosen {
  /** Of the hub, or of the log `source`; `watch(addresses)` when others are watched. */
  constructor(place, source, watch) {
    this.place = place;
    this.watch = watch;
    this.watched = [];
    this.source = source;
    this.chosen = source ? null : remembered("trace.lines", null);
    this.known = "";
    this.onLin = new Set();
    this.kinds = new Map();
    this.wasLin = false;
    this.search = document.createElement("input");
    this.search.type = "search";
    this.search.setAttribute("aria-label", word("trace.search-lines"));
    this.search.placeholder = word("trace.search-lines");
    this.search.addEventListener("input", () => this.narrow());
    this.asked = this.taken = 0; // looks
    this.look();
    setInterval(() => this.look(), LOOK_MS);
    place.addEventListener("change", (event) => {
      if (event.target === this.search) return;
      this.chosen = [...place.querySelectorAll("input:checked")].map((box) => box.value);
      if (!this.source) remember("trace.lines", this.chosen);
      this.set(this.chosen);
    });
  }

  /** Lines of another source from now on. */
  forget(source) {
    this.source = source;
    this.watched = [];
    this.chosen = source ? null : remembered("trace.lines", null);
    this.taken = this.asked; // answers that come yet are about the other one
    this.look();
  }

  async look() {
    this.asked += 1;
    const { asked, source } = this;
    let told;
    try {
      const answer = await fetch(`/trace/lines?${new URLSearchParams({ source })}`);
      if (!answer.ok) return; // the page's head says that the hub is away
      told = await answer.json();
    } catch {
      return; // likewise the server
    }
    if (asked <= this.taken) return; // a later one was quicker
    this.taken = asked;
    document.dispatchEvent(new CustomEvent("recording", { detail: told.recording }));
    document.dispatchEvent(new CustomEvent("logs", { detail: told.logs }));
    document.dispatchEvent(new CustomEvent("replay", { detail: told.replay }));
    if (source !== this.source) return; // its log is closed
    busesAre(told.lines.map((line) => line.bus));
    this.kinds = new Map(told.lines.map((line) => [line.address, line.kind]));
    this.onLin = new Set(told.lines.filter((line) => line.kind === "LIN" && line.running).map((line) => line.address));
    const there = told.lines.map((line) => line.address);
    const chosen = this.chosen?.filter((one) => there.includes(one));
    const pulled = this.watched.filter((one) => !there.includes(one)); // named until it is back, or others are chosen
    this.set([...(chosen?.length ? chosen : this.source ? there : usual(told.lines, this.watched)), ...pulled]);
    this.show(told.lines);
  }

  /** Whether a LIN line is watched. */
  get lin() {
    return this.watched.some((address) => this.onLin.has(address));
  }

  /** Those that are watched, each with "CAN" or "LIN"; a log that has just been opened may not have said them yet. */
  async channels() {
    await this.look();
    return this.watched.map((address) => ({ address, kind: this.kinds.get(address) }));
  }

  /** Others are watched, or a LIN line among them has come to run or has stopped: columns differ then. */
  set(addresses) {
    const lin = this.lin;
    if (addresses.join() === this.watched.join() && lin === this.wasLin) return;
    this.watched = addresses;
    this.wasLin = this.lin;
    this.watch(addresses);
  }

  show(lines) {
    const known = JSON.stringify([lines, this.watched]);
    if (known === this.known) return;
    this.known = known;
    const focused = document.activeElement?.value;
    const legend = this.place.querySelector("legend");
    const many = lines.length > MANY;
    this.search.hidden = !many;
    const byBus = (one, other) => !one.bus - !other.bus || one.bus.localeCompare(other.bus, "en", { numeric: true });
    this.place.replaceChildren(legend, this.search, ...(many ? [...lines].sort(byBus) : lines).map((line) => {
      const label = document.createElement("label");
      label.className = `check chip-choice${line.running ? " running" : ""}`;
      const box = document.createElement("input");
      box.type = "checkbox";
      box.value = line.address;
      box.checked = this.watched.includes(line.address);
      const name = document.createElement("span");
      name.textContent = `${line.address} ${line.bus || "–"}`;
      label.append(box, name);
      return label;
    }));
    if (focused) this.place.querySelector(`input[value="${CSS.escape(focused)}"]`)?.focus();
    this.narrow();
    this.explain(lines);
  }

  /** Of many lines those that are searched for, and those that are chosen. */
  narrow() {
    const words = this.search.value.toLowerCase().split(/\s+/);
    for (const label of this.place.querySelectorAll("label")) {
      const text = label.textContent.toLowerCase();
      label.hidden = !label.control.checked && !words.every((one) => text.includes(one));
    }
  }

  /** Why nothing comes from the chosen lines, if it is known. */
  explain(lines) {
    const said = lines.filter((line) => this.watched.includes(line.address)).map(({ address, state, running }) => {
      if (state === "bus-off") return word("trace.bus-off-line", { address });
      return running ? "" : word("trace.still-line", { address });
    });
    const all = said.filter(Boolean);
    const some = all.slice(0, MOST_SAID);
    if (all.length > some.length) some.push(word("trace.more-still", { count: all.length - some.length }));
    document.getElementById("empty").textContent = [...some, word("trace.empty")].join(" ");
  }

  /** What the server says of the lines that this viewer asked for. */
  told(lines) {
    const open = lines.length > 0 && lines.every((line) => this.watched.includes(line.address) && line.open && !line.trouble);
    document.body.dataset.listening = open && lines.length === this.watched.length ? "yes" : "no";
    const troubles = lines.filter((line) => line.trouble).map(({ trouble, address }) => (trouble.startsWith("trace.") ? word(trouble, { address }) : trouble));
    document.getElementById("live").textContent = [...new Set(troubles)].join("; ");
  }
}

/** One that runs, of these the watched one: the rows of a line go out of sight with it. */
function usual(lines, watched) {
  const rank = (line) => 2 * line.running + watched.includes(line.address);
  const byBus = new Map();
  for (const line of lines) {
    if (!line.bus && lines.some((one) => one.bus)) continue; // on no bus nothing happens
    const kept = byBus.get(line.bus);
    if (!kept || rank(line) > rank(kept)) byBus.set(line.bus, line);
  }
  return [...byBus.values()].map((line) => line.address);
}
