// Rows that this viewer has marked, by their numbers; kept as long as the tab.
const KEY = "canwire.trace.marks";

export class Marks {
  constructor() {
    this.numbers = JSON.parse(sessionStorage.getItem(KEY) || "[]");
  }

  has(number) {
    return this.numbers.includes(number);
  }

  toggle(number) {
    this.numbers = this.has(number) ? this.numbers.filter((one) => one !== number) : [...this.numbers, number];
    this.numbers.sort((one, other) => one - other);
    sessionStorage.setItem(KEY, JSON.stringify(this.numbers));
  }

  clear() {
    this.numbers = [];
    sessionStorage.removeItem(KEY);
  }

  /** The next one after (step 1) or before a number, going round at the end; null without any. */
  next(number, step) {
    const ordered = step > 0 ? this.numbers : [...this.numbers].reverse();
    return ordered.find((one) => (one - number) * step > 0) ?? ordered[0] ?? null;
  }
}
