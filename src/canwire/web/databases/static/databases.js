// The dialog of network descriptions: what is open, for which bus, and files that are opened or dropped.
import { say, word } from "../base/base.js";
import { disableForReaders, post } from "../base/forms.js";

const element = (id) => document.getElementById(id);
export const ENDINGS = /\.(dbc|arxml|kcd|sym|ldf)$/i;
let buses = [];

/** Names of buses that a file can be chosen for. */
export function busesAre(names) {
  buses = [...new Set(names.filter(Boolean))].sort();
}

/** Send a file to the server; true when it is open. */
export async function openDatabase(file) {
  try {
    const answer = await fetch(`/databases/open?${new URLSearchParams({ name: file.name })}`, { method: "POST", body: file });
    say((await answer.json()).message, !answer.ok);
    await changed();
    return answer.ok;
  } catch {
    say(word("base.unreachable"), true);
    return false;
  }
}

async function changed() {
  document.dispatchEvent(new CustomEvent("databases"));
  await list();
}

async function list() {
  const answer = await fetch("/databases").catch(() => null); // the head says that the server is away
  if (!answer?.ok) return;
  const found = await answer.json();
  const place = element("database-list");
  place.replaceChildren(...found.map(item));
  if (!found.length) place.append(Object.assign(document.createElement("li"), { className: "quiet", textContent: word("databases.none") }));
  disableForReaders(place);
}

function item({ key, name, bus, messages }) {
  const row = document.createElement("li");
  const title = Object.assign(document.createElement("b"), { textContent: name });
  const count = Object.assign(document.createElement("span"), { className: "quiet", textContent: word("databases.count", { count: messages }) });
  const choice = document.createElement("select");
  choice.setAttribute("aria-label", word("databases.bus", { name }));
  choice.dataset.writes = "";
  choice.append(new Option(word("databases.every-bus"), ""), ...[...new Set([...buses, bus].filter(Boolean))].map((one) => new Option(one)));
  choice.value = bus;
  choice.addEventListener("change", async () => {
    await post("/databases/assign", { key, bus: choice.value });
    changed();
  });
  const close = Object.assign(document.createElement("button"), { type: "button", className: "small", textContent: "×" });
  close.setAttribute("aria-label", word("databases.close", { name }));
  close.dataset.writes = "";
  close.addEventListener("click", async () => {
    await post("/databases/close", { key });
    changed();
  });
  row.append(title, count, choice, close);
  return row;
}

element("open-database").addEventListener("click", () => element("database-file").click());
element("database-file").addEventListener("change", async (event) => {
  for (const file of [...event.target.files]) await openDatabase(file);
  event.target.value = "";
});
document.addEventListener("click", (event) => {
  if (event.target.closest("[data-opens=databases]")) list();
});
