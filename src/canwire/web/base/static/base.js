// What every view's script has at hand: words, choices that are kept, the status line, keys.
const texts = JSON.parse(document.getElementById("words").textContent);

/** The text of a key in the page's language, with {name}s put in. */
export function word(key, values = {}) {
  return texts[key].replace(/\{(\w+)\}/g, (_, name) => String(values[name]));
}

const language = document.documentElement.lang;

/** A number with the point or comma of the page's language. */
export function decimal(number, digits) {
  const text = number.toFixed(digits);
  return language === "de" ? text.replace(".", ",") : text;
}

/** A text that begins with a number as programs write it, with that point or comma. */
export function localised(text) {
  return language === "de" ? text.replace(/^(-?\d+)\.(\d+)/, "$1,$2") : text;
}

export const writer = document.body.dataset.writer === "yes";

/** A kept choice, or the fallback. */
export function remembered(key, fallback) {
  const kept = localStorage.getItem(`canwire.${key}`);
  if (kept === null) return fallback;
  try {
    return JSON.parse(kept);
  } catch {
    return fallback; // somebody else's
  }
}

export function remember(key, value) {
  localStorage.setItem(`canwire.${key}`, JSON.stringify(value));
}

/** One line for people, read out by screen readers. */
export function say(text, bad = false) {
  const status = document.getElementById("status");
  status.textContent = text;
  status.classList.toggle("bad", bad);
}

/** True while somebody types, when single keys mean letters. */
export function typing(event) {
  return event.target.closest("input:not([type=checkbox]):not([type=radio]), select, textarea, dialog") !== null;
}

const LOOK_MS = 1000;
const PATIENCE_MS = 900; // for an answer: a server that ended or hangs is said within two seconds

/** The head's dot: is the server there, and the hub. What a dead server has shown is greyed out. */
async function watchLink() {
  const link = document.getElementById("link");
  for (;;) {
    let text = null;
    try {
      const answer = await fetch("/link", { signal: AbortSignal.timeout(PATIENCE_MS) });
      if (answer.ok) text = await answer.text();
    } catch {
      // the server is away: said below
    }
    document.body.classList.toggle("unreachable", text === null);
    if (text === null) {
      const dot = document.createElement("span");
      dot.className = "dot bad";
      link.replaceChildren(dot, word("base.unreachable"));
    } else if (link.dataset.told !== text) link.innerHTML = text;
    link.dataset.told = text ?? "";
    const hub = link.querySelector("[data-hub]")?.dataset.hub ?? "";
    if (hub !== document.body.dataset.hub) {
      document.body.dataset.hub = hub;
      // a page that was made while the hub was away knows no lines
      if (hub === "there" && document.body.dataset.rendered === "away") location.reload();
      document.dispatchEvent(new CustomEvent("hub", { detail: hub }));
    }
    await new Promise((done) => { setTimeout(done, LOOK_MS); });
  }
}

/** Of questions whose answers may overtake each other only the newest counts: returns `ask()`, whose result says whether it still is that one. */
export function questions() {
  let newest = 0;
  return () => {
    newest += 1;
    const number = newest;
    return () => number === newest;
  };
}

/** A web socket that comes back by itself: `hear(event.data)`, `state(open)`. Returns {send(object)}. */
export function live(path, hear, state = () => {}, opened = () => {}) {
  let socket = null;
  const open = () => {
    socket = new WebSocket(`ws://${location.host}${path}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { state(true); opened(); };
    socket.onmessage = (event) => hear(event.data);
    socket.onclose = () => { state(false); setTimeout(open, 500); };
  };
  open();
  return {
    send(told) {
      if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(told));
    },
  };
}

function keepChoices() {
  for (const field of document.querySelectorAll("[data-remember]")) {
    const key = field.dataset.remember;
    const kept = remembered(key, null);
    if (field.tagName === "DETAILS") {
      field.open = kept === true;
      field.addEventListener("toggle", () => remember(key, field.open));
      continue;
    }
    if (field.type === "checkbox") {
      if (kept !== null) field.checked = kept;
    } else if (kept !== null && (field.tagName !== "SELECT" || [...field.options].some((one) => one.value === kept))) {
      field.value = kept;
    }
    field.addEventListener("change", () => remember(key, field.type === "checkbox" ? field.checked : field.value));
  }
}

function themeSwitch() {
  const button = document.getElementById("theme");
  const show = () => button.setAttribute("aria-pressed", String(document.documentElement.dataset.theme === "dark"));
  show();
  button.addEventListener("click", () => {
    const theme = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    document.documentElement.dataset.theme = theme;
    localStorage.setItem("canwire.theme", theme);
    show();
    document.dispatchEvent(new CustomEvent("theme"));
  });
}

keepChoices();
themeSwitch();
watchLink();
document.getElementById("language").addEventListener("change", (event) => {
  const address = new URL(location.href);
  address.searchParams.set("lang", event.target.value);
  location.assign(address);
});
document.addEventListener("keydown", (event) => {
  if (!event.altKey || event.ctrlKey || event.metaKey) return;
  const tab = document.querySelector(`nav a[data-key="${event.code.replace("Digit", "")}"]`);
  if (tab) {
    event.preventDefault();
    tab.click();
  }
});
