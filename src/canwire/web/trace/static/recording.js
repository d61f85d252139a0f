// The recording into a file at the server: begun and ended here, and how far it is.
import { say, word } from "../base/base.js";
import { post } from "../base/forms.js";

const button = document.getElementById("record");
const files = document.getElementById("recordings");

document.addEventListener("recording", ({ detail: now }) => {
  button.setAttribute("aria-pressed", String(now.running));
  button.textContent = now.running
    ? word("trace.stop-record", { rows: now.rows, missed: now.missed })
    : word("trace.record");
  const whole = now.running ? now.files.slice(0, -1) : now.files;
  if (files.children.length !== whole.length) {
    files.replaceChildren(...whole.map((number) => {
      const link = document.createElement("a");
      link.href = `/trace/recording?number=${number}`;
      link.download = "";
      link.textContent = word("trace.recording-file", { number });
      return link;
    }));
  }
  if (now.trouble) say(now.trouble, true);
});

/** Pressed: record what is watched, or end it. */
export function record(lines) {
  const running = button.getAttribute("aria-pressed") === "true";
  return running ? post("/trace/record-stop", {}) : post("/trace/record", { lines: lines.join(",") });
}
