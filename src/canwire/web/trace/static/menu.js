// What can be done with a row: by the other mouse button, the menu key, or Shift+F10.

/**
 * `chosen(index)` when it opens at a row: what is known of it, for its index may change meanwhile, or null. `act(what, row)`
 * gets that when something is taken; `selected()` is the index for the keyboard.
 */
export function menu(body, place, chosen, act, selected) {
  let chosenRow = null;
  const close = () => { place.hidden = true; };
  const openAt = (x, y) => {
    place.hidden = false;
    place.style.left = `${Math.min(x, innerWidth - place.offsetWidth - 8)}px`;
    place.style.top = `${Math.min(y, innerHeight - place.offsetHeight - 8)}px`;
    place.querySelector("button").focus();
  };
  body.addEventListener("contextmenu", (event) => {
    const row = event.target.closest(".trace-row");
    const index = row ? row.index : selected();
    if (index < 0) return;
    event.preventDefault();
    chosenRow = chosen(index);
    if (!chosenRow) return;
    const box = (row ?? body).getBoundingClientRect();
    openAt(event.clientX || box.left + 40, event.clientY || box.top + 20);
  });
  place.addEventListener("click", (event) => {
    const what = event.target.closest("button")?.dataset.what;
    close();
    body.focus();
    if (what) act(what, chosenRow);
  });
  place.addEventListener("keydown", (event) => {
    const buttons = [...place.querySelectorAll("button")];
    const at = buttons.indexOf(document.activeElement);
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step) buttons[(at + step + buttons.length) % buttons.length].focus();
    else if (event.key === "Escape" || event.key === "Tab") {
      close();
      body.focus();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });
  document.addEventListener("pointerdown", (event) => { if (!place.contains(event.target)) close(); });
}
