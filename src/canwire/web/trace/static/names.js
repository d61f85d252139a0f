// Names of frames by the bus of their line, as the databases that are open have them.
import { questions, word } from "../base/base.js";

const described = document.getElementById("described");

export class Names {
  /** `changed()` when there are others. */
  constructor(changed) {
    this.names = {};
    this.files = [];
    this.version = -1;
    this.buses = "";
    this.changed = changed;
    this.ask = questions();
  }

  get any() {
    return this.files.length > 0;
  }

  of(bus, id) {
    return this.names[bus]?.[id] ?? "";
  }

  /** Ask for those of these buses, unless they are known in this version. */
  async look(version, buses) {
    const wanted = [...new Set(buses)].sort().join(",");
    if (version === this.version && wanted === this.buses) return;
    this.version = version;
    this.buses = wanted;
    const newest = this.ask();
    const answer = await fetch(`/trace/names?${new URLSearchParams({ buses: wanted })}`).catch(() => null); // the head tells
    const told = answer?.ok ? await answer.json() : null;
    if (!newest()) return; // others were asked for meanwhile
    if (!told) {
      this.version = -1;
      return;
    }
    this.names = told.names;
    this.files = told.files;
    described.textContent = told.files.length ? word("trace.database", { name: told.files.join(", ") }) : "";
    this.changed();
  }
}
