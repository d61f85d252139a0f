// Forms with data-action and buttons with data-post are sent here; faults are shown at their fields.
import { say, word, writer } from "./base.js";

let posted = 0;
let newest = 0; // of the posts whose messages were said

/** Say a post's message: that something earlier was done does not cover what was said of something later. */
function tell(number, text, bad) {
  if (!bad && number < newest) return;
  newest = Math.max(newest, number);
  say(text, bad);
}

/** Post fields; true when it was done. Faults go to the fields of `form`, the message to the status line. */
export async function post(path, fields, form = null) {
  posted += 1;
  const number = posted;
  clear(form);
  let answer, told;
  try {
    answer = await fetch(path, { method: "POST", body: new URLSearchParams(fields), redirect: "error" });
    const type = answer.headers.get("content-type") || "";
    told = type.startsWith("application/json") ? await answer.json() : { message: await answer.text(), faults: {} };
  } catch {
    tell(number, word("base.unreachable"), true);
    return false;
  }
  const faults = Object.values(told.faults || {});
  tell(number, form || !faults.length ? told.message : faults.join(" "), !answer.ok);
  if (form) show(form, told, answer.ok);
  if (form && !answer.ok) form.dispatchEvent(new CustomEvent("refused", { detail: told }));
  if (answer.ok) document.body.dispatchEvent(new CustomEvent("changed", { detail: { path } }));
  return answer.ok;
}

function clear(form) {
  if (!form) return;
  for (const note of form.querySelectorAll(".fault")) note.remove();
  for (const field of form.querySelectorAll("[aria-invalid]")) {
    field.removeAttribute("aria-invalid");
    field.removeAttribute("aria-describedby");
  }
}

function show(form, told, done) {
  const entries = Object.entries(told.faults || {});
  let first = null;
  for (const [name, text] of entries) {
    const field = form.elements.namedItem(name);
    if (!(field instanceof Element)) continue;
    const note = document.createElement("span");
    note.className = "fault";
    note.id = `fault-${form.id || "form"}-${name}`;
    note.textContent = text;
    field.setAttribute("aria-invalid", "true");
    field.setAttribute("aria-describedby", note.id);
    (field.closest("label") || field).after(note); // inside it would be part of the field's name
    first = first || field;
  }
  if (first) first.focus();
  else if (!done) {
    const note = document.createElement("p");
    note.className = "fault";
    note.setAttribute("role", "alert");
    note.textContent = told.message;
    form.append(note);
  }
}

document.addEventListener("submit", async (event) => {
  const form = event.target;
  if (!form.dataset.action) return;
  event.preventDefault();
  if (form.hasAttribute("aria-busy")) return; // a second Enter before the answer would do it twice
  form.setAttribute("aria-busy", "true");
  const done = await post(form.dataset.action, new FormData(form, event.submitter), form);
  form.removeAttribute("aria-busy");
  if (done) {
    if ("closes" in form.dataset) form.closest("dialog")?.close();
    if ("clears" in form.dataset) form.reset();
  }
});

document.addEventListener("click", (event) => {
  const opener = event.target.closest("[data-opens]");
  if (opener) openDialog(opener);
  const button = event.target.closest("button[data-post]");
  if (!button || button.disabled) return;
  const { post: path, confirm: question, ...fields } = button.dataset;
  delete fields.writes;
  if (question && !window.confirm(question)) return;
  post(path, fields);
});

/** A button's data-set-NAME are put into the dialog's fields; a child [data-shows=NAME] shows it. */
function openDialog(opener) {
  const dialog = document.getElementById(opener.dataset.opens);
  for (const [key, value] of Object.entries(opener.dataset)) {
    if (!key.startsWith("set")) continue;
    const name = key.slice(3).toLowerCase();
    const field = dialog.querySelector(`[name="${name}"]`);
    if (field) field.value = value;
    const shown = dialog.querySelector(`[data-shows="${name}"]`);
    if (shown) shown.textContent = value;
  }
  clear(dialog.querySelector("form"));
  dialog.showModal();
}

document.addEventListener("click", (event) => {
  if (event.target.closest("[data-closes-dialog]")) event.target.closest("dialog").close();
});

/** Viewers without the token see what could be done, and that they may not. */
export function disableForReaders(root = document) {
  if (writer) return;
  for (const one of root.querySelectorAll("[data-writes]")) {
    one.disabled = true;
    one.title = word("base.viewing-only");
  }
}

disableForReaders();
document.addEventListener("htmx:afterSwap", (event) => disableForReaders(event.target));
