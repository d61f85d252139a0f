// A list of any length drawn with as many row elements as fit on the screen, which are used again and again.

const ROW_PX = 22;
const TALLEST_PX = 15_000_000; // browsers cannot do 33 million; a longer list is scrolled in proportion

const SYNC_MS = 200; // between two changes of the scroll bar while rows come: each costs a layout of the page

/**
 * `columns`: [{key, label, number}]; `fill(element, index)` writes a row's texts; `opened(index)` when one is chosen;
 * `moved()` when other rows are in sight. `show(count)` says how many there are now.
 * While `follow` is set the newest one is in sight.
 *
 * Rows are in a window that does not scroll, at places that do not change while they follow; the spacer beside it has
 * the list's length. Nothing here asks the browser for a size while rows come: that would force an immediate layout.
 */
export class List {
  constructor(head, body, rows, spacer, fill, opened, moved) {
    Object.assign(this, { head, body, rows, spacer, fill, opened, moved });
    this.count = 0;
    this.selected = -1;
    this.follow = true;
    this.elements = [];
    this.columns = [];
    this.height = body.clientHeight;
    this.top = 0; // scrollTop
    this.length = 0; // of the spacer, in pixels
    this.timer = null;
    this.exact = null; // [scrollTop, first]: the first row where scrolling in proportion is too coarse
    body.addEventListener("scroll", () => this.scrolled());
    body.addEventListener("wheel", (event) => {
      if (event.deltaY < 0) this.unfollow();
      if (this.coarse && !event.ctrlKey) {
        event.preventDefault();
        this.goTo(this.first + event.deltaY / ROW_PX);
        this.followAtEnd();
      }
    }, { passive: false });
    body.addEventListener("keydown", (event) => this.key(event));
    body.addEventListener("click", (event) => {
      const row = event.target.closest(".trace-row");
      if (row) this.select(row.index, true);
    });
    new ResizeObserver(() => {
      this.height = body.clientHeight;
      this.sync();
      this.draw();
      moved();
    }).observe(body);
  }

  /** Rows that fit, with a part of one. */
  get room() {
    return this.height / ROW_PX;
  }

  get coarse() {
    return this.count * ROW_PX > TALLEST_PX;
  }

  /** The topmost row in sight, with its part. */
  get first() {
    if (this.follow) return Math.max(0, this.count - this.room);
    if (!this.coarse) return this.top / ROW_PX;
    if (this.exact?.[0] === this.top) return this.exact[1];
    return (this.top / (TALLEST_PX - this.height)) * Math.max(0, this.count - this.room);
  }

  goTo(first) {
    this.sync();
    const last = Math.max(0, this.count - this.room);
    const wanted = Math.max(0, Math.min(first, last));
    this.body.scrollTop = this.coarse ? (wanted / last) * (TALLEST_PX - this.height) : wanted * ROW_PX;
    this.top = this.body.scrollTop;
    this.exact = [this.top, wanted];
    this.draw();
    this.moved();
  }

  /** By somebody, or by the list itself, which has shown that already. */
  scrolled() {
    const top = this.body.scrollTop;
    if (this.follow) {
      if (top >= Math.min(this.top, this.length - this.height) - ROW_PX) return;
      this.follow = false; // its bar was drawn upwards
    } else if (Math.abs(top - this.top) <= 1) return;
    this.top = top;
    this.followAtEnd();
    this.draw();
    this.moved();
  }

  /** Somebody has come to the end of the scroll bar, which rows that have just come may not have made longer yet. */
  followAtEnd() {
    if (this.top + this.height >= this.length - 2) this.setFollow(true);
  }

  /** The scroll bar is as long, and where, it should be. */
  sync() {
    clearTimeout(this.timer);
    this.timer = null;
    const length = Math.min(this.count * ROW_PX, TALLEST_PX);
    if (length !== this.length) this.spacer.style.height = `${length}px`;
    this.length = length;
    if (!this.follow) return;
    this.body.scrollTop = length;
    this.top = Math.max(0, length - this.height);
  }

  label(columns) {
    this.columns = columns;
    this.head.replaceChildren(...columns.map((column) => {
      const cell = document.createElement("div");
      cell.setAttribute("role", "columnheader");
      cell.className = `c-${column.key}${column.number ? " num" : ""}`;
      cell.textContent = column.label;
      cell.dataset.key = column.key;
      return cell;
    }));
    for (const element of this.elements) element.remove();
    this.elements = [];
  }

  show(count) {
    const fewer = count < this.count;
    this.count = count;
    if (fewer) this.sync();
    else this.timer ??= setTimeout(() => this.sync(), SYNC_MS);
    this.draw();
  }

  /** Rows have gone at the beginning: what is in sight stays in sight. */
  dropped(count) {
    if (this.selected >= 0) this.selected = Math.max(-1, this.selected - count);
    if (!this.follow) this.goTo(this.first - count);
  }

  draw() {
    const { first } = this;
    const begin = Math.floor(first);
    const room = Math.ceil(this.room) + 1;
    while (this.elements.length < room) this.elements.push(this.make());
    for (let k = 0; k < this.elements.length; k += 1) {
      const element = this.elements[k];
      const index = begin + k;
      const there = k < room && index < this.count;
      if (element.hidden === there) element.hidden = !there;
      if (!there) continue;
      const at = Math.round((index - first) * ROW_PX);
      if (element.at !== at) element.style.transform = `translateY(${at}px)`;
      element.at = at;
      if (element.index !== index) element.setAttribute("aria-rowindex", index + 2); // the head is row 1
      element.index = index;
      const selected = String(index === this.selected);
      if (element.ariaSelected !== selected) element.ariaSelected = selected;
      this.fill(element, index);
    }
  }

  make() {
    const row = document.createElement("div");
    row.className = "trace-row";
    row.setAttribute("role", "row");
    for (const column of this.columns) {
      const cell = document.createElement("div");
      cell.setAttribute("role", "gridcell");
      cell.className = `c-${column.key}${column.number ? " num" : ""}`;
      row.append(cell);
    }
    this.rows.append(row);
    return row;
  }

  unfollow() {
    if (this.count > this.room) this.setFollow(false);
  }

  setFollow(follow) {
    const before = this.follow;
    if (before && !follow) this.sync(); // it stays where it is
    this.follow = follow;
    if (!before && follow) this.sync();
  }

  /** Another list comes: its newest row is in sight, or its first one. */
  begin(follow) {
    this.follow = follow;
    if (follow) return;
    this.body.scrollTop = this.top = 0;
    this.exact = null;
  }

  select(index, open) {
    if (!this.count) return;
    this.selected = Math.max(0, Math.min(index, this.count - 1));
    if (this.selected < this.first) this.goTo(this.selected);
    else if (this.selected + 1 > this.first + this.room) this.goTo(this.selected + 1 - this.room);
    this.draw();
    if (open) this.opened(this.selected);
  }

  key(event) {
    const page = Math.max(1, Math.floor(this.room) - 1);
    const steps = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page };
    if (event.key in steps) {
      const down = steps[event.key] > 0 && !this.follow;
      this.unfollow();
      this.select((this.selected < 0 ? this.count : this.selected) + steps[event.key], false);
      if (down) this.followAtEnd();
    } else if (event.key === "Home") {
      this.unfollow();
      this.select(0, false);
    } else if (event.key === "End") {
      this.select(this.count - 1, false);
      this.setFollow(true);
    } else if (event.key === "Enter" && this.selected >= 0) {
      this.opened(this.selected);
    } else return;
    event.preventDefault();
  }
}
