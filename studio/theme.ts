// Runs before anything is drawn: marks a framed page, and sets the system's light or dark theme until a button chooses.
const dark = matchMedia("(prefers-color-scheme: dark)");
const root = document.documentElement;
if (parent !== window) root.dataset.framed = "1";

const follow = (): void => {
  if (root.dataset.chosen === undefined) root.dataset.theme = dark.matches ? "dark" : "light";
};
dark.addEventListener("change", follow);
// A page that shows the studio in a frame may choose the theme.
addEventListener("message", ({ source, data }) => {
  if (source !== parent || parent === window || !["light", "dark"].includes(data?.theme)) return;
  root.dataset.theme = data.theme;
  root.dataset.chosen = "";
});
follow();
