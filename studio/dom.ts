// Helpers to find, make and observe elements of the page.

/** The element of the page with this id; throws if the page has none. */
export function part<E extends HTMLElement = HTMLElement>(id: string): E {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no ${id}`);
  return found as E;
}

/** Show a sentence in the page's alert; "" hides the alert. */
export function say(sentence: string): void {
  part("alert").textContent = sentence;
  part("alert").hidden = sentence === "";
}

/** The color `--name` of the page's theme. */
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

/** Returns a function that requests a drawing: many requests before the next frame draw once. */
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

/** A label with its control. */
export function labeled(text: string, control: HTMLElement): HTMLElement {
  const label = element("label", "choice", text);
  label.append(control);
  return label;
}

/** A drop-down list of (text, value) options; `chosen` is called with the value of a new choice. */
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

/** A value above its label, an entry of a list of facts. */
export function fact(value: string, label: string): HTMLElement {
  const box = element("div");
  box.append(element("dt", "", value), element("dd", "", label));
  return box;
}

/** Close a menu on Escape, on a click outside it, and on a click on one of its buttons. */
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
