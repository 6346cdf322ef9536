// Without this script the table stands as it is, the best AUC first.
(() => {
  const table = document.querySelector("table.methods");
  if (!table) return;
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];

  const valueIn = (row, column) =>
    column === 0 ? row.cells[0].textContent : parseFloat(row.cells[column].dataset.value);

  // A figure that is missing is NaN, and stays last whichever way the others stand.
  const compare = (a, b, sign) => {
    if (Number.isNaN(a) || Number.isNaN(b)) return Number.isNaN(a) - Number.isNaN(b);
    return sign * (typeof a === "string" ? a.localeCompare(b, "en") : a - b);
  };

  const sortBy = (head, column) => {
    const first = head.dataset.first;
    const other = first === "ascending" ? "descending" : "ascending";
    const order = head.getAttribute("aria-sort") === first ? other : first;
    const sign = order === "ascending" ? 1 : -1;
    const rows = [...body.rows];
    rows.sort((a, b) => compare(valueIn(a, column), valueIn(b, column), sign));
    body.append(...rows);
    heads.forEach((each) => each.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", order);
  };

  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(head, column));
    head.append(button);
  });
})();
