// What an answer's head says beside the rows: what is missing, what is wrong with the filter, how far it is.
import { word } from "../base/base.js";
import { refused } from "./colours.js";

const element = (id) => document.getElementById(id);
const MANY = 100_000; // rows that are left to look at

let before = "";

export function showHead(head, filter) {
  const field = element("filter");
  const said = JSON.stringify([head.fault, head.badRules, head.lost, head.late, head.first, head.trouble, head.leftOut, filter]);
  showProgress(head);
  if (said === before) return; // nothing is touched, and laid out, in vain
  before = said;
  element("filter-fault").textContent = head.fault ? word("trace.bad-filter", { part: head.fault }) : "";
  if (head.fault) field.setAttribute("aria-invalid", "true");
  else field.removeAttribute("aria-invalid");
  refused(head.badRules);
  element("grid").dataset.filter = filter; // what the rows on the screen have passed
  const counts = { lost: head.lost, late: head.late, gone: head.first };
  for (const [id, count] of Object.entries(counts)) {
    element(id).textContent = count;
    element(id).parentElement.classList.toggle("bad", count > 0);
    element(id).parentElement.hidden = count === 0 && id !== "lost";
  }
  element("trouble").textContent = head.trouble;
  element("left-out").hidden = !head.leftOut;
  element("left-out").textContent = head.leftOut ? word("trace.left-out", { count: head.leftOut }) : "";
}

/** How much of the history was looked at. */
function showProgress(head) {
  const scanned = head.end - head.cursor > MANY ? Math.floor((100 * head.cursor) / head.end) : 100;
  const text = scanned < 100 ? word("trace.scanning", { percent: scanned }) : "";
  if (element("scanning").textContent !== text) element("scanning").textContent = text;
}
