// The filter as it is typed, and the direction beside it; both are remembered.
import { remember, remembered } from "../base/base.js";

const PAUSE_MS = 120; // after the last letter

export class FilterField {
  /** `changed({filter, direction})` when others are wanted. */
  constructor(changed) {
    this.changed = changed;
    this.field = document.getElementById("filter");
    this.direction = document.getElementById("direction");
    this.timer = 0;
    this.field.value = remembered("trace.filter", "");
    this.direction.value = remembered("trace.direction", "");
    this.direction.addEventListener("change", () => {
      remember("trace.direction", this.direction.value);
      this.set(this.field.value, true);
    });
    this.field.addEventListener("input", () => this.set(this.field.value));
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.set("", true);
      else if (event.key === "Enter") this.set(this.field.value, true);
    });
  }

  get look() {
    return { filter: this.field.value, direction: this.direction.value };
  }

  set(text, now = false) {
    if (this.field.value !== text) this.field.value = text;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      remember("trace.filter", text);
      this.changed(this.look);
    }, now ? 0 : PAUSE_MS);
  }
}
