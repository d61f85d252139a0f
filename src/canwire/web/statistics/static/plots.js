// Four plots of one line's counters, by uPlot; asked for once a second, what is new alone.
import { decimal, localised, word } from "../base/base.js";

const LOOK_MS = 1000;
const KEPT = 1200;
const HEIGHT = 170;
const NUMBER = 0, TIME = 1;
const EPOCH = 1e9; // seconds: what is later counts since 1970
const PLOTS = {
  load: [["load", 2, "--plot-1"]],
  rates: [["sent", 3, "--plot-1"], ["received", 4, "--plot-2"]],
  errors: [["errors", 5, "--plot-3"], ["arbitration", 6, "--plot-4"]],
  counters: [["tec", 7, "--plot-3"], ["rec", 8, "--plot-2"]],
};
const lineChoice = document.getElementById("line");
const spanChoice = document.getElementById("span");
let columns = empty();
let plots = [];

function empty() {
  return Array.from({ length: 9 }, () => []);
}

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function make() {
  for (const plot of plots) plot.destroy();
  plots = Object.entries(PLOTS).map(([name, series]) => {
    const place = document.getElementById(`plot-${name}`);
    const axis = { stroke: colour("--quiet"), grid: { stroke: colour("--rule"), width: 1 }, ticks: { stroke: colour("--rule"), width: 1 }, font: "12px system-ui" };
    const made = new uPlot({
      width: place.clientWidth,
      height: HEIGHT,
      cursor: { sync: { key: "statistics" } },
      scales: { x: { time: true, range: range }, y: { range: (_, low, high) => [0, Math.max(1, (high || 0) * 1.1)] } },
      axes: [{ ...axis, values: (_, ticks) => ticks.map(moment) }, { ...axis, size: 52, values: (_, ticks) => ticks.map((one) => localised(`${one}`)) }],
      series: [
        { label: word("statistics.time"), value: (plot, value) => told(moment, value ?? plot.data[0].at(-1)) },
        ...series.map(([key, , name]) => ({
          label: word(`statistics.series-${key}`), stroke: colour(name), width: 1.6, points: { show: false },
          value: (plot, value, at) => told((one) => decimal(one, key === "load" ? 1 : 0), value ?? plot.data[at].at(-1)),
        })),
      ],
    }, dataOf(series), place);
    made.series_ = series;
    return made;
  });
}

/** What the cursor is at, without one the newest value. */
function told(shown, value) {
  return value === null || value === undefined ? "–" : shown(value);
}

/** The time of day; of a hub whose epoch is not known, seconds since it began. */
function moment(seconds) {
  return seconds > EPOCH ? new Date(seconds * 1000).toLocaleTimeString("en-GB") : localised(`${Math.round(seconds * 10) / 10} s`);
}

function dataOf(series) {
  return [columns[TIME], ...series.map(([, at]) => columns[at])];
}

// At least a second, also of a single sample: to a range of no length uPlot adds ticks without an end.
function range() {
  const last = columns[TIME].at(-1) ?? 0;
  const first = Math.max(columns[TIME][0] ?? 0, last - Number(spanChoice.value));
  return [first, Math.max(last, first + 1)];
}

const newest = () => columns[NUMBER].at(-1) ?? 0;

async function look() {
  const line = lineChoice.value;
  const after = newest();
  let told;
  try {
    const answer = await fetch(`/statistics/samples?${new URLSearchParams({ line, after })}`);
    if (!answer.ok) return;
    told = await answer.json();
  } catch {
    return; // the page's head says that server or hub are away
  }
  if (line !== lineChoice.value || after !== newest() || !told.columns.length) return; // asked again meanwhile
  told.columns[TIME] = told.columns[TIME].map((seconds) => seconds + (told.epoch ?? 0));
  // a hub that was started again counts its time from the beginning
  if (columns[TIME].length && told.columns[TIME][0] < columns[TIME].at(-1)) columns = empty();
  told.columns.forEach((column, at) => {
    columns[at].push(...column);
    columns[at].splice(0, columns[at].length - KEPT);
  });
  draw();
}

function draw() {
  for (const plot of plots) plot.setData(dataOf(plot.series_));
  const load = columns[2].at(-1);
  if (load !== undefined) {
    document.getElementById("plot-load").setAttribute("aria-label", word("statistics.load-now", { load: decimal(load, 1) }));
  }
}

if (lineChoice.dataset.chosen === undefined && localStorage.getItem("canwire.statistics.line") === null) {
  const running = lineChoice.querySelector("option[data-running]");
  if (running) lineChoice.value = running.value;
}
lineChoice.addEventListener("change", () => { columns = empty(); draw(); look(); });
spanChoice.addEventListener("change", draw);
document.addEventListener("theme", make);
addEventListener("resize", () => {
  for (const plot of plots) plot.setSize({ width: plot.root.parentElement.clientWidth, height: HEIGHT });
});
make();
look();
setInterval(look, LOOK_MS);
