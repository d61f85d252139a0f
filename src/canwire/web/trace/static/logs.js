// Logs: one that is opened or dropped here is looked at as the hub's lines are; what is shown is saved in any format.
import { decimal, say, word } from "../base/base.js";
import { post } from "../base/forms.js";
import { ENDINGS, openDatabase } from "../databases/databases.js";

const element = (id) => document.getElementById(id);
const choice = element("source");

/** Of all rows of this look, of those that are shown ("filtered"), or of the marked ones. */
export function save(look, fields, marked) {
  const { source, since, until } = look;
  const query = { lines: look.lines.join(","), source, since, format: fields.get("format"), errors: "true" };
  if (until !== null) query.until = until;
  if (fields.get("what") === "marked") query.numbers = marked.join(",");
  if (fields.get("what") === "filtered") Object.assign(query, { filter: look.filter, direction: look.direction });
  const link = document.createElement("a");
  link.href = `/trace/log?${new URLSearchParams(query)}`;
  link.download = "";
  link.click();
}

/** The dialog has marked rows to save, so many. */
export function offerMarked(count) {
  const option = element("save-marked");
  option.disabled = count === 0;
  option.textContent = word("trace.save-marked", { count });
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

/** `chosen(source)` when another source than `shown` is to be looked at, "" for the hub's lines. */
export function sources(shown, chosen) {
  const offer = (key) => {
    choice.value = key;
    element("close-log").hidden = element("replay").hidden = key === "";
  };
  const show = (key) => {
    shown = key;
    offer(key);
    chosen(key);
  };
  const open = async (file) => {
    if (file && ENDINGS.test(file.name)) return openDatabase(file);
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
  document.addEventListener("drop", async (event) => {
    event.preventDefault();
    for (const file of [...event.dataTransfer.files]) await open(file);
  });
  document.addEventListener("logs", ({ detail: logs }) => {
    const known = [...choice.options].map((option) => option.value);
    for (const log of logs) if (!known.includes(log.key)) choice.append(new Option(log.name, log.key));
    if (shown && !logs.some((log) => log.key === shown)) { // closed elsewhere, or the server is another one
      if (choice.value === shown) say(word("trace.closed", { name: choice.selectedOptions[0].text }));
      show("");
    } else if (choice.value !== shown) offer(shown);
    for (const option of [...choice.options]) {
      if (option.value && !logs.some((log) => log.key === option.value)) option.remove();
    }
    element("source-choice").hidden = logs.length === 0;
  });
}

/** For each channel of a log a choice of lines: a running one of the same bus, or for the first channel of its kind any that runs. */
function onto(channels, lines) {
  const taken = new Set();
  return channels.map(({ address: channel, kind }, place) => {
    const fit = lines.filter((line) => line.lin === (kind === "LIN")).sort((one, other) => other.running - one.running);
    const free = fit.filter((line) => line.running && !taken.has(line.address));
    const first = channels.findIndex((one) => one.kind === kind) === place;
    const usual = free.find((line) => line.bus === channel) ?? (first ? free[0] : null);
    taken.add(usual?.address);
    const choice = document.createElement("select");
    choice.name = `line.${channel}`;
    choice.append(new Option(word("trace.not-replayed"), ""));
    for (const line of fit) choice.append(new Option(`${line.address} · ${line.bus || "–"}`, line.address));
    choice.value = usual?.address ?? "";
    const label = document.createElement("label");
    const name = document.createElement("span");
    name.textContent = `${channel} (${kind})`;
    label.append(name, choice);
    return label;
  });
}

/** The dialog that plays the opened log onto lines; `look()` is what is looked at, `channels()` promises its lines with their kinds. */
export function replays(look, channels) {
  const form = element("replay-form");
  let running = false;
  let told = null; // the number of the last replay whose end was said
  element("replay").addEventListener("click", async () => {
    if (running) {
      post("/trace/replay-stop", {});
      return;
    }
    const away = () => null; // which the head says
    const [answer, played] = await Promise.all([fetch("/send/choices").catch(away), channels()]);
    if (!answer?.ok) return;
    const { lines } = await answer.json();
    const place = element("replay-lines");
    place.replaceChildren(place.querySelector("legend"), ...onto(played, lines));
    element("replaying").showModal();
  });
  form.addEventListener("submit", () => {
    form.elements.source.value = look().source;
    form.elements.filter.value = element("replay-filtered").checked ? look().filter : "";
  }, { capture: true });
  document.addEventListener("replay", ({ detail: now }) => {
    if (told !== null && now.number > told && !now.running) say(word("trace.replay-over", now), Boolean(now.trouble));
    if (told === null || !now.running) told = now.running ? now.number - 1 : now.number;
    running = now.running;
    const button = element("replay");
    button.setAttribute("aria-pressed", String(running));
    button.textContent = running
      ? word("trace.replay-stop", { sent: now.sent, at: decimal(now.at_s, 1) })
      : `${word("trace.replay")}…`;
    if (running) button.hidden = false;
  });
}
