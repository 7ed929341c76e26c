"use strict";
document.querySelectorAll("table.sortable").forEach((table) => {
  const body = table.tBodies[0];
  table.querySelectorAll("thead th").forEach((head, index) => {
    head.querySelector("button").addEventListener("click", () => {
      const rising = head.getAttribute("aria-sort") !== "ascending";
      table.querySelectorAll("thead th").forEach((th) => th.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", rising ? "ascending" : "descending");
      const numeric = head.classList.contains("number");
      const value = (row) => {
        const cell = row.cells[index];
        const text = cell.dataset.sort;
        if (numeric) return text === undefined ? null : Number(text);
        return cell.textContent.trim();
      };
      const order = (a, b) => {
        const x = value(a), y = value(b);
        if (numeric) {
          if (x === null || Number.isNaN(x)) return y === null || Number.isNaN(y) ? 0 : 1;
          if (y === null || Number.isNaN(y)) return -1;
          return rising ? x - y : y - x;
        }
        return (rising ? 1 : -1) * x.localeCompare(y, "en", { numeric: true });
      };
      [...body.rows].sort(order).forEach((row) => body.append(row));
    });
  });
});
addEventListener("beforeprint", () => {
  document.querySelectorAll("details:not(.screen-only)").forEach((d) => { d.open = true; });
});
// Tables and pictures that are wider than the page say so.
const hint = () => document.querySelectorAll(".table, .plot").forEach((wide) => {
  wide.classList.toggle("scrolls", wide.scrollWidth > wide.clientWidth + 1);
});
hint();
addEventListener("resize", hint);
// a link into what is folded opens it
const unfold = () => {
  const target = location.hash && document.getElementById(location.hash.slice(1));
  if (!target) return;
  const inner = target.querySelector(":scope > details.fold");
  if (inner) inner.open = true;
  for (let d = target.closest("details"); d; d = d.parentElement.closest("details")) d.open = true;
  target.scrollIntoView();
};
addEventListener("hashchange", unfold);
unfold();
