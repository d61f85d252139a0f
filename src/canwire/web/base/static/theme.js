// Runs before the page is drawn: the chosen theme, or the system's.
"use strict";
(() => {
  const kept = localStorage.getItem("canwire.theme");
  const dark = kept ? kept === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
})();
