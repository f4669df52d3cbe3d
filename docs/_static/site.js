// Names for the two landmarks that the theme leaves without, and a title for the page of the search.
document.addEventListener("DOMContentLoaded", () => {
  document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
  document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "This page");
  const results = document.querySelector("#search-results");
  if (results && !document.querySelector("h1")) results.insertAdjacentHTML("beforebegin", "<h1>Search</h1>");
});
