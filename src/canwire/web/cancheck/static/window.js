// What is in a window: rows, names of frames, event buttons, filter bits, generators.
import { word } from "../base/base.js";

const MOST = 500; // rows shown
const SVG = "http://www.w3.org/2000/svg";

function icon(kind) {
  const drawing = document.createElementNS(SVG, "svg");
  drawing.setAttribute("class", `event ${kind}`);
  drawing.setAttribute("role", "img");
  drawing.setAttribute("aria-label", kind);
  const title = document.createElementNS(SVG, "title");
  title.textContent = kind;
  const use = document.createElementNS(SVG, "use");
  use.setAttribute("href", `#event-${kind}`);
  drawing.append(title, use);
  return drawing;
}

function cell(text) {
  const made = document.createElement("td");
  made.textContent = text;
  return made;
}

function eventRow(number, [kind, time, ...rest]) {
  const row = document.createElement("tr");
  row.dataset.at = number;
  const first = cell("");
  first.append(icon(kind), time);
  row.append(first, ...rest.map(cell));
  return row;
}

function messageRow(number, cells) {
  const row = document.createElement("tr");
  row.dataset.at = number;
  row.append(...cells.map(cell));
  return row;
}

/** New rows at the end; those that were cleared, or are too many, go. Who looks at the end stays there. */
export function addRows(section, told) {
  const box = section.querySelector("[data-list]");
  const body = box.querySelector("tbody");
  const atEnd = box.scrollHeight - box.scrollTop - box.clientHeight < 30;
  const make = told.kind === "receive" ? eventRow : messageRow;
  body.append(...told.rows.map((cells, place) => make(told.start + place, cells)));
  while (body.firstChild && (body.childElementCount > MOST || Number(body.firstChild.dataset.at) < told.first)) {
    body.firstChild.remove();
  }
  if (atEnd) box.scrollTop = box.scrollHeight;
}

export function draw(section, told, main) {
  const part = (name) => section.querySelector(`[data-${name}]`);
  part("trouble").hidden = !told.trouble;
  part("trouble").textContent = told.trouble;
  part("log").textContent = told.log ? word("cancheck.logging", { name: told.log }) : "";
  part("logs").textContent = told.log ? word("cancheck.close-log") : word("cancheck.open-log");
  if (told.kind === "receive" && told.code !== undefined) drawReceive(section, told, part);
  if (told.kind === "send" && told.generators) drawSend(section, told, part);
}

function drawReceive(section, told, part) {
  part("events").textContent = `0x${told.events.toString(16).toUpperCase().padStart(3, "0")}`;
  for (const button of section.querySelectorAll("button[data-event]")) {
    button.setAttribute("aria-pressed", String((told.events & Number(button.dataset.event)) !== 0));
  }
  part("filter").textContent = `Code 0x${told.code}, ${word("cancheck.mask")} 0x${told.mask}`;
  const [identifier, data] = told.standard.split(" ");
  part("standard").textContent = grouped(identifier) + (data ? ` · ${grouped(data)}` : "");
  part("extended").textContent = told.extended ? grouped(told.extended) : word("cancheck.no-ext");
  part("extended").classList.toggle("say", !told.extended);
}

/** In fours, counted from bit 0. */
function grouped(bits) {
  return bits.replace(/(?!^)(?=(?:.{4})+$)/g, " ");
}

function drawSend(section, told, part) {
  const counts = [];
  if (told.given_up) counts.push(word("cancheck.given-up", { count: told.given_up }));
  if (told.lost) counts.push(word("cancheck.not-heard", { count: told.lost }));
  part("counts").hidden = !counts.length;
  part("counts").textContent = counts.join(" ");
  drawGenerators(section, told, part);
}

/** Rows are changed in place: one that is being clicked stays. */
function drawGenerators(section, told, part) {
  const chosen = Number(section.dataset.chosen ?? -1);
  const body = part("generators").querySelector("tbody");
  while (body.childElementCount < 2 * told.generators.length) {
    body.append(...newRows(told, body.childElementCount / 2));
  }
  told.generators.forEach((one, index) => {
    const [row, note] = [body.children[2 * index], body.children[2 * index + 1]];
    row.classList.toggle("chosen", index === chosen);
    row.querySelector("input").checked = index === chosen;
    one.row.forEach((text, place) => put(place ? row.cells[place] : row.querySelector("span"), text));
    const why = one.trouble || (one.waits ? word("cancheck.waits") : "");
    note.hidden = !why;
    put(note.cells[0], why);
  });
  const current = told.generators[chosen];
  const writes = document.body.dataset.writer === "yes";
  part("activates").disabled = part("edits").disabled = !current || !writes;
  part("activates").checked = Boolean(current?.active);
}

function put(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

function newRows(told, index) {
  const row = document.createElement("tr");
  row.dataset.index = index;
  const choice = document.createElement("input");
  Object.assign(choice, { type: "radio", name: `chosen-${told.number}`, value: index });
  choice.setAttribute("aria-label", word("cancheck.select", { index: index.toString(16).toUpperCase() }));
  const first = cell("");
  first.append(choice, document.createElement("span"));
  row.append(first, ...Array.from({ length: 6 }, () => cell("")));
  const note = document.createElement("tr");
  note.className = "note";
  note.append(cell(""));
  note.cells[0].colSpan = 7;
  return [row, note];
}
