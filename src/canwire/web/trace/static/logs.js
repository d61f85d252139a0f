// Logs: one that is opened or dropped here is looked at as the hub's lines are; what is shown is saved in any format.
import { say, word } from "/static/base/base.js";
import { post } from "/static/base/forms.js";

const element = (id) => document.getElementById(id);
const choice = element("source");

/** Of all rows of this look, or with "filtered" of those that are shown. */
export function save(look, fields) {
  const { source, since, until } = look;
  const query = { lines: look.lines.join(","), source, since, format: fields.get("format"), errors: "true" };
  if (until !== null) query.until = until;
  if (fields.get("filtered")) Object.assign(query, { filter: look.filter, direction: look.direction });
  const link = document.createElement("a");
  link.href = `/trace/log?${new URLSearchParams(query)}`;
  link.download = "";
  link.click();
}

async function send(file) {
  say(word("trace.reading"));
  const query = new URLSearchParams({ name: file.name });
  try {
    const answer = await fetch(`/trace/open?${query}`, { method: "POST", body: file });
    const told = await answer.json();
    say(told.message, !answer.ok);
    return answer.ok ? told.key : null;
  } catch {
    say(word("base.unreachable"), true);
    return null;
  }
}

/** `chosen(source)` when another source is to be looked at, "" for the hub's lines. */
export function sources(look, chosen) {
  const show = (key) => {
    choice.value = key;
    element("close-log").hidden = key === "";
    chosen(key);
  };
  const open = async (file) => {
    const key = file ? await send(file) : null;
    if (!key) return;
    choice.append(new Option(file.name, key));
    element("source-choice").hidden = false;
    show(key);
  };
  choice.append(new Option(word("trace.live-source"), ""));
  element("open-log").addEventListener("click", () => element("log-file").click());
  element("log-file").addEventListener("change", (event) => {
    open(event.target.files[0]);
    event.target.value = "";
  });
  choice.addEventListener("change", () => show(choice.value));
  element("close-log").addEventListener("click", () => {
    const key = choice.value;
    show("");
    post("/trace/close", { key });
  });
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    open(event.dataTransfer.files[0]);
  });
  document.addEventListener("logs", ({ detail: logs }) => {
    const known = [...choice.options].map((option) => option.value);
    for (const log of logs) if (!known.includes(log.key)) choice.append(new Option(log.name, log.key));
    for (const option of [...choice.options]) {
      if (option.value && !logs.some((log) => log.key === option.value)) option.remove();
    }
    element("source-choice").hidden = logs.length === 0;
  });
}
