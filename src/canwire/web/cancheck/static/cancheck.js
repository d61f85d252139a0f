// CanCheck: its main window, and a panel for each window that is open. The server says by web socket how all of it is.
import { live, remember, remembered, say } from "../base/base.js";
import { disableForReaders, post } from "../base/forms.js";
import { bindGenerators } from "./generator.js";
import { addRows, draw } from "./window.js";

const one = (id) => document.getElementById(id);
const panels = one("windows");
const known = new Map(); // key -> {section, told}
const waiting = new Set(); // frames on their way
let main = { running: false };
let order = []; // keys of all windows, as they were opened

// the main window

/** A field that somebody is typing into is left alone. */
function put(field, value) {
  if (document.activeElement !== field) field.value = value;
}

function drawMain(told) {
  const before = main;
  main = told;
  one("starting").hidden = told.running;
  one("running").hidden = one("leave").hidden = !told.running;
  const trouble = one("trouble");
  trouble.hidden = !told.trouble;
  trouble.textContent = told.trouble || "";
  one("driver").textContent = told.driver || "";
  if (!told.running || told.trouble) return;
  one("port-legend").textContent = `CAN Port ${told.port}`;
  put(one("port"), told.port);
  const rate = one("rate-form").elements.rate;
  if (before.rate !== told.rate || before.port !== told.port) rate.value = told.rate;
  put(one("mode"), told.mode);
  put(one("format"), told.format);
  if (String(before.commands) !== String(told.commands)) drawCommands(told);
}

function drawCommands(told) {
  one("rates").replaceChildren(...told.rates.map((rate) => new Option(rate, rate)));
  one("commands").replaceChildren(
    ...told.commands.map(([number, name]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "small mono";
      button.textContent = name;
      Object.assign(button.dataset, { post: "/cancheck/command", number, name, writes: "" });
      return button;
    }),
  );
  disableForReaders(one("commands"));
}

for (const field of document.querySelectorAll("[data-chooses]")) {
  field.addEventListener("change", async () => {
    const name = field.dataset.chooses;
    await post(`/cancheck/${name}`, { [name]: field.value });
    field.value = main[name]; // a refused setting leaves what is shown; an accepted one comes by the socket
  });
}
one("rate-form").addEventListener("refused", ({ detail: told }) => {
  if (!Object.keys(told.faults).length) one("rate-form").elements.rate.value = main.rate; // what the port has
});
one("restart").addEventListener("click", () => post("/cancheck/restart", { port: one("start-form").elements.port.value }));
one("set-registry").addEventListener("click", async () => {
  const answer = await fetch("/cancheck/entries");
  const text = await answer.text();
  if (!answer.ok) return say(text, true);
  one("registry-form").innerHTML = text;
  disableForReaders(one("registry-form"));
  one("registry-dialog").showModal();
});
one("registry-dialog").addEventListener("close", () => one("registry-form").replaceChildren());

// windows

async function insert(told) {
  if (waiting.has(told.key)) return;
  waiting.add(told.key);
  const answer = await fetch(`/cancheck/window?number=${told.number}&kind=${told.kind}`);
  const text = await answer.text();
  waiting.delete(told.key);
  if (!answer.ok || known.has(told.key)) return;
  const frame = document.createElement("template");
  frame.innerHTML = text.trim();
  const section = frame.content.firstElementChild;
  const after = order.slice(order.indexOf(told.key) + 1).find((key) => known.has(key));
  panels.insertBefore(section, after ? known.get(after).section : null);
  known.set(told.key, { section, told });
  bind(section, told);
  disableForReaders(section);
  const latest = early.get(told.key);
  early.delete(told.key);
  update(latest);
}

function bind(section, told) {
  const headers = section.querySelector("[data-hides]");
  const hide = (hidden) => {
    section.classList.toggle("bare", hidden);
    headers.setAttribute("aria-pressed", String(hidden));
  };
  hide(remembered(`cancheck.bare.${told.kind}`, false));
  headers.addEventListener("click", () => {
    const hidden = !section.classList.contains("bare");
    remember(`cancheck.bare.${told.kind}`, hidden);
    hide(hidden);
  });
  section.querySelector("[data-logs]").addEventListener("click", () => toggleLog(known.get(told.key).told));
  if (told.kind === "send") bindGenerators(section, () => known.get(told.key).told, () => main);
}

function toggleLog(told) {
  const fields = { number: told.number, kind: told.kind };
  if (told.log) {
    post("/cancheck/close-log", fields);
    return;
  }
  const form = one("log-form");
  form.elements.number.value = fields.number;
  form.elements.kind.value = fields.kind;
  if (!form.elements.file.value) form.elements.file.value = "cancheck.txt";
  form.elements.overwrite.checked = false;
  one("log-dialog").showModal();
}

const early = new Map(); // rows that came before their frame did

function update(told) {
  const window = known.get(told.key);
  if (window) {
    window.told = told;
    addRows(window.section, told);
    draw(window.section, told, main);
    return;
  }
  const kept = early.get(told.key);
  early.set(told.key, kept ? { ...told, rows: [...kept.rows, ...told.rows], start: kept.start } : told);
  insert(told);
}

function hear(text) {
  const told = JSON.parse(text);
  drawMain(told.main);
  order = told.windows.map((window) => window.key);
  const keys = new Set(order);
  for (const [key, { section }] of known) {
    if (keys.has(key)) continue;
    section.remove();
    known.delete(key);
  }
  for (const window of told.windows) update(window);
}

/** What this page has shown belongs to a connection that is over: the next one sends everything again. */
function forget(open) {
  if (open) return;
  for (const { section } of known.values()) section.remove();
  known.clear();
  early.clear();
}

live("/cancheck/live", hear, forget);
