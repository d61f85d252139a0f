// Registers are rendered again every second: keeps open ones open, and marks the bits that have changed.
import { remember, remembered } from "../base/base.js";

const MARKED_MS = 2000; // how long a changed bit stays marked
const place = document.getElementById("registers");
let open = new Set(remembered("boards.open-chips", []));
let before = new Map();
const changed = new Map(); // bit -> until when

function bits() {
  const found = new Map();
  for (const chip of place.querySelectorAll(".chip")) {
    for (const row of chip.querySelectorAll("tr[data-register]")) {
      row.querySelectorAll(".bits b").forEach((bit, index) => {
        found.set(`${chip.dataset.chip} ${row.dataset.register} ${index}`, bit);
      });
    }
  }
  return found;
}

place.addEventListener("htmx:afterSwap", () => {
  for (const chip of place.querySelectorAll(".chip")) chip.open = open.has(chip.dataset.chip);
  const now = performance.now();
  const after = new Map();
  for (const [name, bit] of bits()) {
    after.set(name, bit.textContent);
    if (before.has(name) && before.get(name) !== bit.textContent) changed.set(name, now + MARKED_MS);
    if ((changed.get(name) || 0) > now) bit.classList.add("changed");
  }
  before = after;
});

place.addEventListener("toggle", (event) => {
  const chip = event.target.dataset.chip;
  if (!chip || !event.target.isConnected) return;
  if (event.target.open) open.add(chip);
  else open.delete(chip);
  remember("boards.open-chips", [...open]);
}, true);
