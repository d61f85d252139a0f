// Panels: values, switches and sliders bound to signals; this browser keeps them, and saves them to files.
import { live, localised, questions, remember, remembered, say, word, writer } from "../base/base.js";
import { post } from "../base/forms.js";
import { busesAre } from "../databases/databases.js";

const WHAT = "canwire panel";
const KINDS = ["value", "switch", "slider"];
const element = (id) => document.getElementById(id);
const form = element("part-form");
let parts = checked(remembered("panels.parts", [])) ?? [];
let shown = [];
let choices = { lines: [], messages: {} };

/** The parts as they may be kept; null for anything else. */
function checked(found) {
  const fits = (part) => KINDS.includes(part?.kind) && ["line", "message", "signal"].every((name) => typeof part[name] === "string");
  return Array.isArray(found) && found.length <= 200 && found.every(fits) ? found : null;
}

const socket = live("/panels/live", (text) => show(JSON.parse(text)), () => {}, () => bind());

function bind() {
  socket.send({ bound: parts.map(({ line, message, signal }) => [line, message, signal]) });
}

function changed() {
  remember("panels.parts", parts);
  draw();
  bind();
}

function draw() {
  element("no-parts").hidden = parts.length > 0;
  shown = parts.map(make);
  element("parts").replaceChildren(...shown.map((one) => one.card));
}

function make(part, index) {
  const card = Object.assign(document.createElement("section"), { className: "card part" });
  const title = Object.assign(document.createElement("h2"), { textContent: part.signal, id: `part-${index}` });
  card.setAttribute("aria-labelledby", title.id);
  const now = Object.assign(document.createElement("div"), { className: "now", textContent: "–" });
  const from = Object.assign(document.createElement("p"), { className: "hint", textContent: `${part.message} · ${part.line}` });
  const remove = Object.assign(document.createElement("button"), { type: "button", className: "small remove", textContent: "×" });
  remove.setAttribute("aria-label", word("panels.remove", { signal: part.signal }));
  remove.addEventListener("click", () => {
    parts = parts.filter((one) => one !== part);
    changed();
  });
  card.append(title, now, remove);
  const control = part.kind === "switch" ? makeSwitch(part) : part.kind === "slider" ? makeSlider(part) : null;
  if (control) card.append(control);
  card.append(from);
  return { part, card, now, control, touched: 0 };
}

function set(part, value) {
  return post("/panels/set", { line: part.line, message: part.message, signal: part.signal, value });
}

function makeSwitch(part) {
  const button = Object.assign(document.createElement("button"), { type: "button", className: "switch", textContent: word("panels.off"), disabled: !writer });
  button.setAttribute("role", "switch");
  button.setAttribute("aria-checked", "false");
  button.setAttribute("aria-label", part.signal);
  button.addEventListener("click", () => set(part, button.getAttribute("aria-checked") === "true" ? part.minimum ?? 0 : part.maximum ?? 1));
  return button;
}

function makeSlider(part) {
  const slider = Object.assign(document.createElement("input"), { type: "range", min: part.minimum ?? 0, max: part.maximum ?? 100, disabled: !writer });
  slider.step = (slider.max - slider.min) / 1000 >= 1 ? Math.round((slider.max - slider.min) / 1000) : "any";
  slider.setAttribute("aria-label", part.signal);
  let busy = false;
  let wanted = null;
  slider.addEventListener("input", async () => { // one request at a time; the last value always goes
    wanted = slider.value;
    if (busy) return;
    busy = true;
    while (wanted !== null) {
      const value = wanted;
      wanted = null;
      await set(part, Number(Number(value).toPrecision(6)));
    }
    busy = false;
  });
  return slider;
}

/** Values in the order of the parts. */
function show(values) {
  shown.forEach((one, k) => {
    const value = values[k];
    const unit = value?.unit ? Object.assign(document.createElement("small"), { textContent: ` ${value.unit}` }) : "";
    one.now.replaceChildren(value ? localised(value.text) : "–", unit);
    if (!value || value.number === null || !one.control) return;
    if (one.part.kind === "slider" && document.activeElement !== one.control) one.control.value = value.number;
    if (one.part.kind === "switch") {
      const on = value.number !== (one.part.minimum ?? 0);
      one.control.setAttribute("aria-checked", String(on));
      one.control.setAttribute("aria-pressed", String(on));
      one.control.textContent = on ? word("panels.on") : word("panels.off");
    }
  });
}

// The dialog: line, message and signal, each of what was chosen before it.
function options(select, names) {
  const before = select.value; // stays chosen where it is among the new ones
  select.replaceChildren(...names.map((name) => new Option(...[name].flat())));
  if ([...select.options].some((one) => one.value === before)) select.value = before;
}

async function look() {
  const answer = await fetch("/send/choices").catch(() => null); // the head says that the server is away
  if (!answer?.ok) return;
  choices = await answer.json();
  busesAre(choices.lines.map((line) => line.bus));
  const running = [...choices.lines].sort((one, other) => other.running - one.running);
  options(form.elements.line, running.map((line) => [`${line.address} · ${line.bus || "–"}`, line.address]));
  await messages();
}

async function messages() {
  const line = choices.lines.find((one) => one.address === form.elements.line.value);
  const names = choices.messages[line?.bus ?? ""]?.[line?.lin ? "lin" : "can"] ?? [];
  options(form.elements.message, names);
  element("no-messages").hidden = names.length > 0;
  element("keep-part").disabled = names.length === 0;
  await signals();
}

let inputs = [];
const askForSignals = questions();
async function signals() {
  const wanted = askForSignals();
  const query = new URLSearchParams({ line: form.elements.line.value, message: form.elements.message.value });
  const answer = await fetch(`/panels/signals?${query}`).catch(() => null); // as above
  const told = answer?.ok ? await answer.json() : [];
  if (!wanted()) return; // another one was chosen meanwhile
  inputs = told;
  options(form.elements.signal, inputs.map((one) => one.name));
}

form.elements.line.addEventListener("change", messages);
form.elements.message.addEventListener("change", signals);
element("add").addEventListener("click", async () => {
  await look();
  element("part-dialog").showModal();
});
form.addEventListener("submit", () => {
  const { kind, line, message, signal } = Object.fromEntries(new FormData(form));
  const { minimum, maximum } = inputs.find((one) => one.name === signal) ?? {};
  parts = [...parts, { kind, line, message, signal, minimum, maximum }];
  changed();
});
element("save-panel").addEventListener("click", () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([JSON.stringify({ what: WHAT, parts }, null, 1)], { type: "application/json" }));
  link.download = "panel.json";
  link.click();
  URL.revokeObjectURL(link.href);
});
element("load-panel").addEventListener("click", () => element("panel-file").click());
element("panel-file").addEventListener("change", async (event) => {
  const [file] = event.target.files;
  event.target.value = "";
  if (!file) return;
  let found = null;
  try {
    const told = JSON.parse(await file.text());
    found = told.what === WHAT ? checked(told.parts) : null;
  } catch {
    // no JSON: told below
  }
  if (!found) return say(word("panels.no-panel", { name: file.name }), true);
  parts = found;
  changed();
  say(word("panels.loaded", { count: parts.length }));
});
document.addEventListener("databases", look);
draw();
