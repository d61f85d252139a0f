// A generator's window: new ones and old ones, which are paused while they are edited.
import { post } from "../base/forms.js";
import { draw } from "./window.js";

const dialog = document.getElementById("generator-dialog");
const form = document.getElementById("generator-form");
const fields = form.elements;
let edited = null; // {number, index} of the one that is paused meanwhile

/** As many bytes as the DLC says; the second line, Wrap and Repeat only with Use Range. */
function fit() {
  const count = /^[0-8]$/.test(fields.dlc.value.trim()) ? Number(fields.dlc.value) : 0;
  const ranging = fields.range.checked;
  for (let place = 0; place < 8; place++) {
    fields[`b${place}`].disabled = place >= count;
    fields[`t${place}`].disabled = place >= count || !ranging;
  }
  form.querySelector(".line.to").hidden = !ranging;
  form.querySelector(".line.from").classList.toggle("alone", !ranging);
  for (const one of form.querySelectorAll(".ranging")) one.hidden = !ranging;
}

function show(told, main, index) {
  form.reset();
  for (const note of form.querySelectorAll(".fault")) note.remove();
  for (const one of form.querySelectorAll("[aria-invalid]")) one.removeAttribute("aria-invalid");
  fields.number.value = told.number;
  fields.index.value = index === null ? "" : index;
  document.getElementById("generator-number").textContent = (index === null ? told.generators.length : index).toString(16).toUpperCase();
  for (const [name, value] of Object.entries(index === null ? {} : told.generators[index].fields)) {
    if (typeof value === "boolean") fields[name].checked = value;
    else fields[name].value = value;
  }
  fields.ext.disabled = main.mode !== 1; // only in CAN 2.0B
  if (fields.ext.disabled) fields.ext.checked = false;
  fit();
  dialog.showModal();
}

form.addEventListener("input", fit);
document.body.addEventListener("changed", (event) => {
  if (event.detail.path === "/cancheck/generator") edited = null; // Activate or Pause
});
dialog.addEventListener("close", () => {
  if (edited) post("/cancheck/cancel-edit", edited);
  edited = null;
});

export function bindGenerators(section, told, main) {
  const chosen = () => Number(section.dataset.chosen ?? -1);
  section.querySelector("[data-generators]").addEventListener("click", (event) => {
    const row = event.target.closest("tr[data-index]");
    if (!row) return;
    section.dataset.chosen = row.dataset.index;
    draw(section, told(), main());
  });
  section.querySelector("[data-generators]").addEventListener("change", (event) => {
    section.dataset.chosen = event.target.value; // by the arrow keys
    draw(section, told(), main());
  });
  section.querySelector("[data-activates]").addEventListener("change", (event) => {
    const what = event.target.checked ? "activate" : "pause";
    post(`/cancheck/${what}`, { number: told().number, index: chosen() });
  });
  section.querySelector("[data-news]").addEventListener("click", () => show(told(), main(), null));
  section.querySelector("[data-edits]").addEventListener("click", async () => {
    const fields = { number: told().number, index: chosen() };
    if (!(await post("/cancheck/edit", fields))) return;
    edited = fields;
    show(told(), main(), fields.index);
  });
}
