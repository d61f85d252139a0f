// Only the fields of the chosen fault are shown.
const form = document.getElementById("fault-form");

function fit() {
  for (const field of form.querySelectorAll("[data-kinds]")) {
    field.hidden = !field.dataset.kinds.split(" ").includes(form.elements.kind.value);
  }
}

form.elements.kind.addEventListener("change", fit);
fit();
