// Colour rules: the first filter that a row passes gives its colour; the server, which knows filters, applies them.
import { remember, remembered, word } from "../base/base.js";

const COLOURS = 6;
const place = document.getElementById("rules");
let kept = remembered("trace.rules", [{ text: "error", colour: 1 }]);
function changed() {
  remember("trace.rules", kept);
  document.dispatchEvent(new CustomEvent("colours"));
}

function show() {
  place.replaceChildren(...kept.map((rule, k) => {
    const row = document.createElement("div");
    row.className = "rule";
    const text = document.createElement("input");
    text.value = rule.text;
    text.className = "mono";
    text.setAttribute("aria-label", word("trace.rule-text"));
    text.addEventListener("change", () => { rule.text = text.value; changed(); });
    const colour = document.createElement("select");
    colour.setAttribute("aria-label", word("trace.rule-colour"));
    for (let one = 1; one <= COLOURS; one += 1) {
      const option = new Option(word(`trace.colour-${one}`), one, false, one === rule.colour);
      colour.append(option);
    }
    colour.className = `tint-${rule.colour}`;
    colour.addEventListener("change", () => {
      rule.colour = Number(colour.value);
      colour.className = `tint-${rule.colour}`;
      changed();
    });
    const remove = document.createElement("button");
    remove.type = "button";
    remove.className = "small";
    remove.textContent = word("trace.remove");
    remove.addEventListener("click", () => { kept.splice(k, 1); show(); changed(); });
    row.append(text, colour, remove);
    return row;
  }));
}

document.getElementById("add-rule").addEventListener("click", () => {
  kept.push({ text: "", colour: (kept.length % COLOURS) + 1 });
  show();
  place.querySelector(".rule:last-child input").focus();
});

/** For the server, which colours rows: filters with their colours. */
export function rules() {
  return kept.map(({ text, colour }) => ({ text, colour }));
}

/** The rules at these places mean nothing. */
export function refused(places) {
  place.querySelectorAll("input").forEach((field, k) => {
    if (places.includes(k)) field.setAttribute("aria-invalid", "true");
    else field.removeAttribute("aria-invalid");
  });
}

show();
