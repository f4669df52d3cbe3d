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
