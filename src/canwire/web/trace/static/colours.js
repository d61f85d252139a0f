// Colour rules: the first filter that a row passes gives its colour.
import { remember, remembered, word } from "/static/base/base.js";
import { compile } from "/static/trace/filter.js";

const COLOURS = 6;
const place = document.getElementById("rules");
let kept = remembered("trace.rules", [{ text: "error", colour: 1 }]);
let names = {};
let tests = [];

function compiled() {
  tests = [];
  kept.forEach((rule, k) => {
    const field = place.querySelectorAll("input")[k];
    try {
      const test = compile(rule.text, names);
      if (test) tests.push([test, rule.colour]);
      field?.removeAttribute("aria-invalid");
    } catch (part) {
      if (typeof part !== "string") throw part;
      field?.setAttribute("aria-invalid", "true");
    }
  });
  document.dispatchEvent(new CustomEvent("colours"));
}

function changed() {
  remember("trace.rules", kept);
  compiled();
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

export const rules = {
  colourOf(rows, at) {
    for (const [test, colour] of tests) if (test(rows, at)) return colour;
    return 0;
  },
  named(found) {
    names = found;
    compiled();
  },
};

show();
compiled();
