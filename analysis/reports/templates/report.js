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

// Every table can be copied, with its heads, for a spreadsheet.
const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
for (const frame of document.querySelectorAll(".frame")) {
  const button = frame.querySelector(".copy");
  const cells = (row) => Array.from(row.cells, (cell) => quoted(cell.textContent.trim().replace(/\s+/g, " ")));
  button.hidden = false;
  button.addEventListener("click", async () => {
    const rows = Array.from(frame.querySelector("table").rows, (row) => cells(row).join(","));
    let said = "Copied";
    try {
      await navigator.clipboard.writeText(`${rows.join("\n")}\n`);
    } catch {
      said = "The browser refused";
    }
    button.textContent = said;
    setTimeout(() => (button.textContent = "Copy as CSV"), 2000);
  });
}

// The rows of a long table that hold all the words of its filter.
for (const field of document.querySelectorAll("input.filter")) {
  const rows = Array.from(field.parentElement.querySelector("tbody").rows);
  field.hidden = false;
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
    }
  });
}

// A click on a figure enlarges it; another, or Escape, closes it.
const enlarged = document.getElementById("enlarged");
for (const picture of document.querySelectorAll("img.enlarges")) {
  const open = () => {
    const large = new Image();
    large.src = picture.src;
    large.alt = picture.alt;
    enlarged.replaceChildren(large);
    enlarged.showModal();
  };
  picture.addEventListener("click", open);
  picture.addEventListener("keydown", (event) => {
    if (event.key === "Enter") open();
  });
}
enlarged.addEventListener("click", () => enlarged.close());

// On paper everything is unfolded, and a table that is wider than the page is made smaller.
const PAPER = 1030; // CSS pixels across A4, landscape, without margins
const folded = [];
addEventListener("beforeprint", () => {
  for (const part of document.querySelectorAll("details:not([open])")) {
    folded.push(part);
    part.open = true;
  }
  for (const table of document.querySelectorAll("table")) {
    const room = table.closest(".beside") ? 0.6 * PAPER : PAPER;
    const shrunk = 7 * (96 / 72) / parseFloat(getComputedStyle(table).fontSize); // to the 7 points of paper
    table.style.zoom = Math.min(1, room / (table.scrollWidth * shrunk));
  }
});
addEventListener("afterprint", () => {
  for (const part of folded.splice(0)) part.open = false;
  for (const table of document.querySelectorAll("table")) table.style.zoom = "";
});
