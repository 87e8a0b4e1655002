// Building elements in code: text is always set as text.

type Attributes = Record<string, string | number | boolean | undefined>;
type Child = Node | string;

function apply(element: Element, attributes: Attributes, children: Child[]): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children);
}

export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  apply(element, attributes, children);
  return element;
}

export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  apply(element, attributes, children);
  return element;
}

/// Sets the text only where it changes: a reader's selection and a screen reader's place stay.
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/// Name, text, and the class of the text.
export type Fact = [string, string, string?];

/// Shows facts in a list; what is the same stays.
export function facts(list: HTMLElement, entries: Fact[]): void {
  const wanted = entries.flatMap(([name, text, tone]) => [
    el("dt", {}, name),
    el("dd", { class: tone, id: `fact-${name.toLowerCase().replaceAll(" ", "-")}`, title: text }, text),
  ]);
  const isSame =
    wanted.length === list.children.length &&
    wanted.every((item, i) => item.isEqualNode(list.children[i] ?? null));
  if (!isSame) list.replaceChildren(...wanted);
}

/// A section with a heading and the age of what it shows.
export function panel(title: string, id: string, ...children: Child[]): { root: HTMLElement; age: HTMLElement } {
  const age = el("span", { class: "age", id: `${id}-age` });
  const head = el("header", {}, el("h2", {}, title), age);
  return { root: el("section", { class: "panel", id, "aria-label": title }, head, ...children), age };
}
