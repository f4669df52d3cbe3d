// Elements of the page.

/** The element of the page with an id. */
export function part<E extends HTMLElement = HTMLElement>(id: string): E {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as E;
}

/** A new element with a class and a text. */
export function element<K extends keyof HTMLElementTagNameMap>(
  name: K,
  style = "",
  text = "",
): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  if (style !== "") made.className = style;
  if (text !== "") made.textContent = text;
  return made;
}

/** Close a menu by Escape, by a click outside of it, or by one on what it holds. */
export function closeOutside(menu: HTMLDetailsElement | null): void {
  document.addEventListener("click", (event) => {
    const target = event.target as Element;
    if (menu !== null && (!menu.contains(target) || target.closest("button") !== null)) menu.open = false;
  });
  document.addEventListener("keydown", (event) => {
    if (menu === null || !menu.open || event.key !== "Escape") return;
    menu.open = false;
    menu.querySelector("summary")?.focus();
  });
}
