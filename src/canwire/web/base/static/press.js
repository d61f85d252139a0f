// A part that is refreshed keeps its elements while one of them is pressed: else a click whose second half meets a new
// element would be lost. The next refresh brings what this one would have shown.
let pressed = null;

const press = (event) => { pressed = event.target; };
const release = () => { setTimeout(() => { pressed = null; }); }; // the click comes first

document.addEventListener("pointerdown", press, true);
document.addEventListener("keydown", press, true);
for (const end of ["pointerup", "pointercancel", "keyup"]) document.addEventListener(end, release, true);
addEventListener("blur", release);

document.addEventListener("htmx:beforeSwap", (event) => {
  if (pressed instanceof Element && event.detail.target.contains(pressed)) event.detail.shouldSwap = false;
});
