// Names for the two landmarks that the theme leaves without, and a title for the page of the search.
document.addEventListener("DOMContentLoaded", () => {
  document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
  document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "This page");
  const results = document.querySelector("#search-results");
  if (results && !document.querySelector("h1")) results.insertAdjacentHTML("beforebegin", "<h1>Search</h1>");
});

// On phones a table of texts becomes a list: a row below the other, each cell after the name of its column. The roles
// keep what it is for those who hear it. Tables of numbers scroll.
const TEXT = 24; // characters from which a cell is a text
const WIDE = 22; // characters of a word that leaves a second column no room
const NAME = 12; // characters from which the first cell of a row is a name of several words

document.addEventListener("DOMContentLoaded", () => {
  const longest = (words) => Math.max(...words.map((word) => word.length));
  for (const table of document.querySelectorAll("article table.docutils")) {
    const names = [...table.querySelectorAll("thead th")].map((name) => name.textContent.trim());
    const rows = [...table.tBodies].flatMap((body) => [...body.rows]);
    const texts = rows.flatMap((row) => [...row.cells].slice(1).filter((cell) => !cell.matches(".text-right")));
    const first = rows.flatMap((row) => row.cells[0].textContent.split(/\s/));
    table.classList.toggle("named", longest(["", ...rows.map((row) => row.cells[0].textContent.trim())]) > NAME);
    if (names.length > 6 || longest(["", ...texts.map((cell) => cell.textContent.trim())]) <= TEXT) continue;
    if (names.length < 3 && longest(first) <= WIDE) continue;
    table.classList.add("texts");
    table.setAttribute("role", "table");
    for (const row of table.rows) row.setAttribute("role", "row");
    for (const row of rows)
      [...row.cells].forEach((cell, k) => {
        cell.setAttribute("role", k === 0 ? "rowheader" : "cell");
        if (cell.textContent.trim() !== "") cell.dataset.column = k === 0 || names.length < 3 ? "" : `${names[k]}: `;
      });
  }
});
