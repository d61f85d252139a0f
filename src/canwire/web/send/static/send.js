// The transmit list: its rows edited where they stand, its dialogs, rows that are sent by their key.
import { questions, remember, remembered, say, typing, word } from "../base/base.js";
import { post } from "../base/forms.js";

const element = (id) => document.getElementById(id);
const dialog = element("row-dialog");
const form = element("row-form");
const list = element("list");
const CAN = ["classic", "remote", "fd", "fdbrs", "sequence"];
const LIN = ["lin", "header", "linsequence"];
let choices = { lines: [], messages: {}, tables: [] };

async function look() {
  const answer = await fetch("/send/choices").catch(() => null); // the head says that the server is away
  if (!answer?.ok) return;
  choices = await answer.json();
  const lines = choices.lines.map((line) => {
    const state = line.running ? "" : ` · ${word(`boards.state-${line.state}`)}`;
    return [line.lin, new Option(`${line.address} · ${line.bus || "–"} · ${line.board}${state}`, line.address)];
  });
  const usual = choices.lines.find((line) => line.running && !line.lin)?.address;
  refill(form.elements.line, lines.map(([, option]) => option), remembered("send.line", usual));
  const lin = lines.filter(([isLin]) => isLin).map(([, option]) => option.cloneNode(true));
  refill(element("lin-form").elements.line, lin);
  const tables = choices.tables.map((table) => new Option(table.name, table.key));
  refill(element("schedule-form").elements.table, [new Option(word("send.typed"), ""), ...tables]);
  element("lin-opener").hidden = lin.length === 0;
}

/** Other options; what was chosen stays chosen. */
function refill(select, options, first = null) {
  const before = select.value || first;
  select.replaceChildren(...options);
  if (options.some((one) => one.value === before)) select.value = before;
}

const chosenLine = () => choices.lines.find((line) => line.address === form.elements.line.value);

async function show(row) {
  await look();
  if (row.line) form.elements.line.value = row.line;
  kinds();
  form.elements.message.value = row.message ?? "";
  await signals();
  for (const [name, value] of Object.entries(row)) {
    const field = form.elements.namedItem(name);
    if (field?.type === "checkbox") field.checked = Boolean(value);
    else if (field && (value || field.tagName !== "SELECT")) field.value = value ?? "";
  }
  fit();
  dialog.showModal();
}

/** The formats and messages of the chosen line. */
function kinds() {
  const line = chosenLine();
  const lin = line?.lin ?? false;
  refill(form.elements.format, (lin ? LIN : CAN).map((kind) => new Option(word(`send.format-${kind}`), kind)));
  const names = choices.messages[line?.bus ?? ""]?.[lin ? "lin" : "can"] ?? [];
  refill(form.elements.message, [new Option(word("send.raw"), ""), ...names.map((name) => new Option(name))]);
  element("message-field").hidden = names.length === 0;
}

/** Each format has its own fields; a message has its signals instead. */
function fit() {
  const message = form.elements.message.value;
  const format = message ? "" : form.elements.format.value;
  for (const field of form.querySelectorAll(".raw")) {
    field.hidden = Boolean(message) || (field.dataset.for !== undefined && !field.dataset.for.split(" ").includes(format));
  }
  const lin = chosenLine()?.lin;
  for (const field of form.querySelectorAll("[data-not-for]")) {
    const refused = field.dataset.notFor.split(" ");
    field.hidden = refused.includes(format) || (lin && refused.includes("lin"));
    const box = field.querySelector("input[type=checkbox]");
    if (field.hidden && box) box.checked = false;
  }
}

const askForSignals = questions();
async function signals() {
  const wanted = askForSignals();
  const message = form.elements.message.value;
  const query = new URLSearchParams({ message, line: form.elements.line.value });
  const answer = message ? await fetch(`/send/signals?${query}`) : null;
  const text = answer?.ok ? await answer.text() : "";
  if (!wanted()) return; // another one was chosen meanwhile
  element("signals").innerHTML = text;
  fit();
}

form.elements.line.addEventListener("change", async () => {
  kinds();
  await signals();
});
form.elements.message.addEventListener("change", signals);
form.elements.format.addEventListener("change", fit);
element("new").addEventListener("click", () => {
  form.reset();
  form.elements.number.value = "";
  show({ line: remembered("send.line", "") });
});
form.addEventListener("submit", () => remember("send.line", form.elements.line.value));

// Rows are edited where they stand: what is typed counts with Enter, or when the field is left.
const editing = () => list.contains(document.activeElement) && document.activeElement.matches("input");
list.addEventListener("change", async ({ target }) => {
  const row = target.closest("tr[data-row]");
  if (!row) return;
  const done = await post("/send/change", { number: row.dataset.row, [target.name]: target.value });
  if (done) target.removeAttribute("aria-invalid");
  else target.setAttribute("aria-invalid", "true");
});
list.addEventListener("keydown", (event) => {
  if (!["Escape", "Enter"].includes(event.key) || !event.target.matches("input")) return;
  if (event.key === "Enter") return void event.target.blur(); // which is a change, if it is one
  event.target.value = event.target.defaultValue;
  event.target.blur();
});
document.addEventListener("htmx:beforeRequest", (event) => {
  if (event.target === list && !list.checkVisibility()) event.preventDefault(); // nobody sees it
});
document.addEventListener("htmx:beforeSwap", (event) => {
  if (event.target !== list || !editing()) return;
  event.detail.shouldSwap = false; // the field keeps the typed text; counts continue
  const came = new DOMParser().parseFromString(event.detail.serverResponse, "text/html");
  for (const row of list.querySelectorAll("tr[data-row]")) {
    const count = came.querySelector(`tr[data-row="${row.dataset.row}"] .counted`);
    if (count) row.querySelector(".counted").replaceWith(document.importNode(count, true));
  }
});

// Lists in files, and the last one of this browser, which outlasts the server.
element("load").addEventListener("click", () => element("list-file").click());
element("list-file").addEventListener("change", async (event) => {
  const [file] = event.target.files;
  if (file) await post("/send/load", { list: await file.text() });
  event.target.value = "";
});
async function keep() {
  const answer = await fetch("/send/file").catch(() => null); // as above
  if (!answer?.ok) return;
  const text = await answer.text();
  const count = JSON.parse(text).rows.length;
  const kept = remembered("send.kept", null);
  if (count) remember("send.kept", text);
  const before = kept ? JSON.parse(kept).rows.length : 0;
  element("restore").hidden = count > 0 || before === 0;
  element("restore").textContent = word("send.restore", { count: before });
}
element("restore").addEventListener("click", () => post("/send/load", { list: remembered("send.kept", "") }));
document.body.addEventListener("changed", ({ detail }) => {
  if (detail.path.startsWith("/send/")) keep();
  if (detail.path === "/send/remove" && !list.querySelectorAll("tr[data-row]")[1]) remember("send.kept", null);
  if (detail.path.startsWith("/send/lin-")) look();
});

// LIN: a line's role, and its schedule.
const linLine = () => element("lin-form").elements.line.value;
element("lin-opener").addEventListener("click", look);
element("lin-down").addEventListener("click", () => post("/send/lin-down", { line: linLine() }, element("lin-form")));
element("schedule-stop").addEventListener("click", () => post("/send/schedule-stop", { line: linLine() }));
element("schedule-form").addEventListener("submit", (event) => {
  event.currentTarget.elements.line.value = linLine();
}, { capture: true });
element("schedule-form").elements.table.addEventListener("change", ({ target }) => {
  element("schedule-form").elements.slots.closest("label").hidden = target.value !== "";
});

document.addEventListener("click", (event) => {
  const button = event.target.closest("button.edit");
  if (button) show(JSON.parse(button.dataset.fields)).catch((error) => say(String(error), true));
});
document.addEventListener("keydown", (event) => {
  if (typing(event) || event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
  for (const row of document.querySelectorAll("tr[data-shortcut]")) {
    if (row.dataset.shortcut && row.dataset.shortcut === event.key.toLowerCase()) {
      post("/send/now", { number: row.dataset.row });
    }
  }
});
document.addEventListener("databases", look);
look();
keep();
