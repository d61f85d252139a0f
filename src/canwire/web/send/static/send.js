// The transmit list's dialog, and rows that are sent by their key.
import { typing } from "/static/base/base.js";
import { post } from "/static/base/forms.js";

const dialog = document.getElementById("row-dialog");
const form = document.getElementById("row-form");

async function show(row) {
  if (form.elements.message) {
    form.elements.message.value = row.message ?? "";
    await signals();
  }
  for (const [name, value] of Object.entries(row)) {
    const field = form.elements.namedItem(name);
    if (field?.type === "checkbox") field.checked = Boolean(value);
    else if (field && value !== null) field.value = value;
  }
  fit();
  dialog.showModal();
}

/** A message has signals, a remote frame a length, any other frame data. */
function fit() {
  const remote = form.elements.format.value === "remote";
  const signals = Boolean(form.elements.message?.value);
  for (const field of form.querySelectorAll(".raw")) field.hidden = signals;
  if (signals) return;
  document.getElementById("data-field").hidden = remote;
  document.getElementById("dlc-field").hidden = !remote;
}

async function signals() {
  const place = document.getElementById("signals");
  const message = form.elements.message.value;
  const answer = message ? await fetch(`/send/signals?${new URLSearchParams({ message })}`) : null;
  place.innerHTML = answer?.ok ? await answer.text() : "";
  fit();
}

form.elements.message?.addEventListener("change", signals);
form.elements.format.addEventListener("change", fit);
document.getElementById("new").addEventListener("click", () => {
  const line = form.elements.line.value;
  form.reset();
  form.elements.number.value = "";
  if (line) form.elements.line.value = line;
  show({});
});
document.getElementById("load").addEventListener("click", () => document.getElementById("list-file").click());
document.getElementById("list-file").addEventListener("change", async (event) => {
  const [file] = event.target.files;
  if (file) await post("/send/load", { list: await file.text() });
  event.target.value = "";
});
document.addEventListener("click", (event) => {
  const button = event.target.closest("button.edit");
  if (button) show(JSON.parse(button.dataset.fields));
});
document.addEventListener("keydown", (event) => {
  if (typing(event) || event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
  for (const row of document.querySelectorAll("tr[data-shortcut]")) {
    if (row.dataset.shortcut && row.dataset.shortcut === event.key.toLowerCase()) {
      post("/send/now", { number: row.dataset.row });
    }
  }
});
