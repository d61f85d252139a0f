// A list of any length drawn with as many row elements as fit on the screen, which are used again and again.

const ROW_PX = 22;
const TALLEST_PX = 15_000_000; // browsers cannot do 33 million; a longer list is scrolled in proportion

/**
 * `columns`: [{key, label, number}]; `fill(element, index)` writes a row's texts; `opened(index)` when one is chosen;
 * `moved()` when other rows are in sight. `show(count)` says how many there are now.
 * While `follow` is set the newest one is in sight.
 */
export class List {
  constructor(head, body, spacer, fill, opened, moved) {
    Object.assign(this, { head, body, spacer, fill, opened, moved });
    this.count = 0;
    this.selected = -1;
    this.follow = true;
    this.elements = [];
    this.columns = [];
    this.exact = null; // [scrollTop, first]: the first row where scrolling in proportion is too coarse
    body.addEventListener("scroll", () => {
      if (this.first + this.room >= this.count - 0.1) this.setFollow(true);
      this.draw();
      moved();
    });
    body.addEventListener("wheel", (event) => {
      if (event.deltaY < 0) this.unfollow();
      if (this.coarse && !event.ctrlKey) {
        event.preventDefault();
        this.goTo(this.first + event.deltaY / ROW_PX);
      }
    }, { passive: false });
    body.addEventListener("keydown", (event) => this.key(event));
    body.addEventListener("click", (event) => {
      const row = event.target.closest(".trace-row");
      if (row) this.select(Number(row.dataset.index), true);
    });
    new ResizeObserver(() => { this.draw(); moved(); }).observe(body);
  }

  /** Rows that fit, with a part of one. */
  get room() {
    return this.body.clientHeight / ROW_PX;
  }

  get coarse() {
    return this.count * ROW_PX > TALLEST_PX;
  }

  /** The topmost row in sight, with its part. */
  get first() {
    const top = this.body.scrollTop;
    if (!this.coarse) return top / ROW_PX;
    if (this.exact?.[0] === top) return this.exact[1];
    return (top / (TALLEST_PX - this.body.clientHeight)) * Math.max(0, this.count - this.room);
  }

  goTo(first) {
    const last = Math.max(0, this.count - this.room);
    const wanted = Math.max(0, Math.min(first, last));
    this.body.scrollTop = this.coarse ? (wanted / last) * (TALLEST_PX - this.body.clientHeight) : wanted * ROW_PX;
    this.exact = [this.body.scrollTop, wanted];
    this.draw();
    this.moved();
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
    this.count = count;
    this.spacer.style.height = `${Math.min(count * ROW_PX, TALLEST_PX)}px`;
    if (this.follow) this.body.scrollTop = this.body.scrollHeight;
    this.draw();
  }

  /** Rows have gone at the beginning: what is in sight stays in sight. */
  dropped(count) {
    if (this.selected >= 0) this.selected = Math.max(-1, this.selected - count);
    if (!this.follow) this.goTo(this.first - count);
  }

  draw() {
    const first = this.follow ? Math.max(0, this.count - this.room) : this.first;
    const begin = Math.floor(first);
    const shift = this.body.scrollTop - first * ROW_PX;
    const room = Math.ceil(this.room) + 1;
    while (this.elements.length < room) this.elements.push(this.make());
    for (let k = 0; k < this.elements.length; k += 1) {
      const element = this.elements[k];
      const index = begin + k;
      const there = k < room && index < this.count;
      element.hidden = !there;
      if (!there) continue;
      element.style.transform = `translateY(${index * ROW_PX + shift}px)`;
      element.dataset.index = index;
      element.setAttribute("aria-rowindex", index + 2); // the head is row 1
      element.setAttribute("aria-selected", String(index === this.selected));
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
    this.body.append(row);
    return row;
  }

  unfollow() {
    if (this.count > this.room) this.setFollow(false);
  }

  setFollow(follow) {
    this.follow = follow;
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
      this.unfollow();
      this.select((this.selected < 0 ? this.count : this.selected) + steps[event.key], false);
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
