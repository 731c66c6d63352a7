"use strict";
// A click on a head sorts by that column: upwards, downwards, then in the order of the page again.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const original = Array.from(body.rows);
  const heads = Array.from(table.tHead.rows[0].cells);
  heads.forEach((head, column) => {
    const numeric = head.classList.contains("number");
    const valueOf = (row) => {
      const text = row.cells[column].dataset.value;
      return text === undefined ? null : numeric ? Number(text) : text;
    };
    const compare = (a, b) => (numeric ? a - b : a < b ? -1 : a > b ? 1 : 0);
    head.setAttribute("aria-sort", "none");
    head.querySelector("button").addEventListener("click", () => {
      const before = head.getAttribute("aria-sort");
      const next = { none: "ascending", ascending: "descending", descending: "none" }[before];
      heads.forEach((other) => other.setAttribute("aria-sort", "none"));
      head.setAttribute("aria-sort", next);
      const rows = original.slice();
      if (next !== "none") {
        const sign = next === "ascending" ? 1 : -1;
        rows.sort((a, b) => {
          const first = valueOf(a);
          const second = valueOf(b);
          if (first === null || second === null) return (first === null) - (second === null);
          return sign * compare(first, second);
        });
      }
      body.append(...rows);
    });
  });
}
