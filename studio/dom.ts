// Elements of the page.

/** The element of the page with an id. */
export function part<E extends HTMLElement = HTMLElement>(id: string): E {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as E;
}

/** Say a sentence in the page's alert; "" takes it away. */
export function say(sentence: string): void {
  part("alert").textContent = sentence;
  part("alert").hidden = sentence === "";
}

/** A color of the page's theme. */
export function colorOf(element: Element, name: string): string {
  return getComputedStyle(element).getPropertyValue(`--${name}`).trim();
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

/** A button with a text. */
export function button(text: string, pressed?: () => void): HTMLButtonElement {
  const made = element("button", "", text);
  made.type = "button";
  if (pressed !== undefined) made.addEventListener("click", pressed);
  return made;
}

/** Draw once in the next frame, however often it is asked for until then. */
export function inFrame(draw: () => void): () => void {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      draw();
    });
  };
}

/** A control behind its label. */
export function labeled(text: string, control: HTMLElement): HTMLElement {
  const label = element("label", "choice", text);
  label.append(control);
  return label;
}

/** A list to choose one of some texts from, by their values; `chosen` hears of another. */
export function selection(
  options: [string, unknown][],
  now: unknown,
  chosen: (value: string) => void,
): HTMLSelectElement {
  const list = element("select");
  list.append(...options.map(([text, value]) => new Option(text, String(value))));
  list.value = String(now);
  list.addEventListener("change", () => chosen(list.value));
  return list;
}

/** A value over its label, in a list of facts. */
export function fact(value: string, label: string): HTMLElement {
  const box = element("div");
  box.append(element("dt", "", value), element("dd", "", label));
  return box;
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
