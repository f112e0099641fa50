"use strict";
// Tables are sorted by the column whose head is pressed: by number where both cells begin with one.
const value = (body, column) => body.rows[0].cells[column].textContent.trim();
const compare = (a, b) => {
  const [x, y] = [parseFloat(a), parseFloat(b)];
  return Number.isNaN(x) || Number.isNaN(y) ? a.localeCompare(b) : x - y;
};
for (const button of document.querySelectorAll("th button")) {
  button.addEventListener("click", () => {
    const head = button.parentElement;
    const table = head.closest("table");
    const up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const order = (a, b) => compare(value(a, head.cellIndex), value(b, head.cellIndex));
    table.append(...[...table.tBodies].sort((a, b) => (up ? order(a, b) : order(b, a))));
  });
}
// A picture that is pressed is shown large.
const dialog = document.querySelector("dialog");
for (const button of document.querySelectorAll("button.zoom")) {
  button.addEventListener("click", () => {
    const picture = button.querySelector("img").cloneNode();
    dialog.querySelector("img")?.remove();
    dialog.append(picture);
    dialog.showModal();
  });
}
dialog?.querySelector("button").addEventListener("click", () => dialog.close());
