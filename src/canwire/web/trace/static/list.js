// A list of any length drawn with as many row elements as fit on the screen, which are used again and again.

const ROW_PX = 22;

/**
 * `columns`: [{key, label, number}]; `fill(cells, place)` writes a row's texts; `opened(index)` when one is chosen.
 * `show(count)` says how many there are now. While `follow` is set the newest one is in sight.
 */
export class List {
  constructor(head, body, spacer, columns, fill, opened) {
    this.body = body;
    this.spacer = spacer;
    this.fill = fill;
    this.opened = opened;
    this.count = 0;
    this.selected = -1;
    this.follow = true;
    this.elements = [];
    this.columns = columns;
    this.head = head;
    this.label(columns);
    body.addEventListener("scroll", () => {
      if (body.scrollTop + body.clientHeight >= this.count * ROW_PX - 2) this.setFollow(true);
      this.draw();
    });
    body.addEventListener("wheel", (event) => { if (event.deltaY < 0) this.unfollow(); }, { passive: true });
    body.addEventListener("keydown", (event) => this.key(event));
    body.addEventListener("click", (event) => {
      const row = event.target.closest(".trace-row");
      if (row) this.select(Number(row.dataset.index), true);
    });
    new ResizeObserver(() => this.draw()).observe(body);
  }

  label(columns) {
    this.columns = columns;
    this.head.replaceChildren(...columns.map((column) => {
      const cell = document.createElement("div");
      cell.setAttribute("role", "columnheader");
      cell.className = `c-${column.key}${column.number ? " num" : ""}`;
      cell.textContent = column.label;
      return cell;
    }));
    for (const element of this.elements) element.remove();
    this.elements = [];
  }

  show(count) {
    this.count = count;
    this.spacer.style.height = `${count * ROW_PX}px`;
    if (this.follow) this.body.scrollTop = count * ROW_PX;
    this.draw();
  }

  /** Rows have gone at the beginning: what is in sight stays in sight. */
  dropped(count) {
    if (this.selected >= 0) this.selected = Math.max(-1, this.selected - count);
    if (!this.follow) this.body.scrollTop = Math.max(0, this.body.scrollTop - count * ROW_PX);
  }

  draw() {
    const first = Math.floor(this.body.scrollTop / ROW_PX);
    const room = Math.ceil(this.body.clientHeight / ROW_PX) + 1;
    while (this.elements.length < room) this.elements.push(this.make());
    for (let k = 0; k < this.elements.length; k += 1) {
      const element = this.elements[k];
      const index = first + k;
      const there = k < room && index < this.count;
      element.hidden = !there;
      if (!there) continue;
      element.style.transform = `translateY(${index * ROW_PX}px)`;
      element.dataset.index = index;
      element.setAttribute("aria-rowindex", index + 1);
      element.setAttribute("aria-selected", String(index === this.selected));
      element.id = `row-${k}`;
      if (index === this.selected) this.body.setAttribute("aria-activedescendant", element.id);
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
    if (this.count * ROW_PX > this.body.clientHeight) this.setFollow(false);
  }

  setFollow(follow) {
    this.follow = follow;
  }

  select(index, open) {
    if (!this.count) return;
    this.selected = Math.max(0, Math.min(index, this.count - 1));
    const top = this.selected * ROW_PX;
    if (top < this.body.scrollTop) this.body.scrollTop = top;
    const bottom = top + ROW_PX - this.body.clientHeight;
    if (bottom > this.body.scrollTop) this.body.scrollTop = bottom;
    this.draw();
    if (open) this.opened(this.selected);
  }

  key(event) {
    const page = Math.max(1, Math.floor(this.body.clientHeight / ROW_PX) - 1);
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
