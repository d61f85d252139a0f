// Curves of signals in one time axis with the trace: several, each with a separate axis, zoomed by dragging.
import { decimal, localised, word } from "../base/base.js";

const LOOK_MS = 500;
const WINDOW_S = 30; // that is followed
const MOST = 8;
const COLOURS = ["#2a7de1", "#e5662f", "#2fa45c", "#9b59d0", "#c9a000", "#d6336c", "#13a8a8", "#7a7a7a"];

export class Plots {
  /** `source()` and `paused()` say what the trace looks at; `goTo(nanoseconds)` shows that time there. */
  constructor(source, paused, goTo) {
    Object.assign(this, { source, paused, goTo });
    this.curves = [];
    this.zoomed = false;
    this.drawn = null;
    setInterval(() => { if (!this.paused()) this.look(); }, LOOK_MS);
    document.addEventListener("theme", () => this.make());
    new ResizeObserver(() => this.drawn?.setSize(this.size())).observe(document.getElementById("plots"));
  }

  add(wanted) {
    const key = `${this.source()} ${wanted.line} ${wanted.id} ${wanted.signal}`;
    if (this.curves.length >= MOST || this.curves.some((one) => one.key === key)) return;
    const colour = COLOURS.find((one) => !this.curves.some((curve) => curve.colour === one));
    this.curves.push({ key, wanted, source: this.source(), colour, from: 0, t: [], v: [] });
    this.make();
    this.look();
  }

  remove(curve) {
    this.curves = this.curves.filter((one) => one !== curve);
    this.make();
  }

  async look() {
    for (const curve of this.curves) {
      const { from } = curve;
      const query = new URLSearchParams({ ...curve.wanted, source: curve.source, from });
      const answer = await fetch(`/trace/plot?${query}`).catch(() => null); // the head says that the server is away
      if (!answer?.ok) continue;
      const told = await answer.json();
      if (from !== curve.from) continue; // asked twice meanwhile: these points are there
      if (told.next < from) Object.assign(curve, { t: [], v: [] });
      curve.from = told.next;
      curve.t.push(...told.t);
      curve.v.push(...told.v);
      curve.value.textContent = curve.v.length ? decimal(curve.v.at(-1), 2) : "–";
    }
    if (this.curves.length) this.draw();
  }

  size() {
    return { width: document.getElementById("plot").clientWidth, height: 180 };
  }

  make() {
    this.drawn?.destroy();
    this.drawn = null;
    document.getElementById("plots").hidden = this.curves.length === 0;
    document.getElementById("plot-keys").replaceChildren(...this.curves.map((curve) => this.label(curve)));
    if (!this.curves.length) return;
    const ink = getComputedStyle(document.body).getPropertyValue("--quiet");
    const rule = getComputedStyle(document.body).getPropertyValue("--rule");
    const axis = { values: (_, ticks) => ticks.map((one) => localised(`${one}`)), stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule } };
    this.drawn = new uPlot({
      ...this.size(),
      legend: { show: false },
      scales: { x: { time: false, range: (_, least, most) => this.range(least, most) } },
      cursor: { drag: { x: true, y: false, setScale: true } },
      hooks: {
        setSelect: [(plot) => { if (plot.select.width > 0) this.zoomed = true; }],
        ready: [(plot) => this.listen(plot)],
      },
      series: [{}, ...this.curves.map(({ key, colour }) => ({ scale: key, stroke: colour, width: 1.5, spanGaps: true }))],
      axes: [axis, ...this.curves.map(({ key, colour }, k) => ({ ...axis, scale: key, stroke: colour, size: 64, grid: { show: k === 0, stroke: rule, width: 1 } }))],
    }, this.joined(), document.getElementById("plot"));
  }

  /** Never of no length: uPlot would add ticks without an end. */
  range(least, most) {
    const first = this.zoomed || this.paused() ? least ?? 0 : Math.max(least ?? 0, (most ?? 0) - WINDOW_S);
    return [first, Math.max(most ?? 0, first + 0.001)];
  }

  listen(plot) {
    let down = 0;
    plot.over.addEventListener("pointerdown", (event) => { down = event.clientX; });
    plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - down) > 3) return; // a zoom
      this.goTo(Math.max(0, Math.round(plot.posToVal(plot.cursor.left, "x") * 1e9)));
    });
    plot.over.addEventListener("dblclick", () => {
      this.zoomed = false;
      this.draw();
    });
  }

  label(curve) {
    const item = document.createElement("li");
    const key = document.createElement("span");
    key.className = "key";
    key.style.background = curve.colour;
    curve.value = document.createElement("b");
    curve.value.textContent = curve.v.length ? decimal(curve.v.at(-1), 2) : "–";
    const remove = document.createElement("button");
    remove.type = "button";
    remove.className = "small";
    remove.textContent = "×";
    remove.setAttribute("aria-label", word("trace.unplot", { name: curve.wanted.signal }));
    remove.addEventListener("click", () => this.remove(curve));
    item.append(key, curve.wanted.signal, curve.value, remove);
    return item;
  }

  joined() {
    return uPlot.join(this.curves.map(({ t, v }) => [t, v]));
  }

  draw() {
    this.drawn?.setData(this.joined(), !this.zoomed);
  }
}
