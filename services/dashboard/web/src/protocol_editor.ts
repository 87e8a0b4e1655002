// The form of one protocol: a field for each key that the checker knows, its message at the field, the text that results.

import { el, setText } from "./dom";
import { choicesOf, enteredText, listIn, placeOf, textIn, tomlOf, valueOf, widgetOf, type ProtocolKey, type Table, type Value } from "./protocol_form";
import type { ProtocolCheck } from "./protocol_words";

type Field = HTMLInputElement | HTMLSelectElement;

interface Entry {
  field: Field;
  message: HTMLElement;
}

/// A table, or each of a list of tables.
interface Section {
  parent: string; // the list in whose tables it is; "" of the document's own
  name: string; // "" of the root
  isList: boolean;
  keys: ProtocolKey[];
}

export class ProtocolEditor {
  readonly root = el("form", { class: "protocol-form", "aria-label": "Protocol" });
  #keys: readonly ProtocolKey[] = [];
  #document: Table = {};
  #entries = new Map<string, Entry>(); // by the checker's name of the key, "posture[2].name"
  #general = el("p", { class: "bad line", id: "protocol-problem", role: "status" });
  #changed: () => void;

  constructor(changed: () => void) {
    this.#changed = changed;
    this.root.addEventListener("submit", (event) => event.preventDefault());
  }

  show(document: Table, keys: readonly ProtocolKey[]): void {
    this.#document = document;
    this.#keys = keys;
    this.#build();
  }

  /// After the kind has changed: the keys of the other kind, the values that both have.
  rekey(keys: readonly ProtocolKey[]): void {
    const focused = document.activeElement?.id ?? "";
    this.#keys = keys;
    this.#build();
    document.getElementById(focused)?.focus();
  }

  get text(): string {
    return tomlOf(this.#document);
  }

  get kind(): string {
    return textIn(this.#document, "kind");
  }

  get name(): string {
    return textIn(this.#document, "name");
  }

  /// The checker's message, at the field that it is about.
  showProblem(problem: ProtocolCheck["problem"]): void {
    const at = problem ? this.#entries.get(problem.key) : undefined;
    for (const { field, message } of this.#entries.values()) {
      const isHere = at?.message === message;
      setText(message, isHere ? problem!.message : "");
      field.setAttribute("aria-invalid", String(isHere));
    }
    setText(this.#general, problem && !at ? problem.message : "");
  }

  #sections(): Section[] {
    const sections = new Map<string, Section>();
    for (const key of this.#keys) {
      const { parent, table, isList } = placeOf(key.name);
      const path = `${parent}.${table}`;
      const section = sections.get(path) ?? { parent, name: table, isList, keys: [] };
      section.keys.push(key);
      sections.set(path, section);
    }
    return [...sections.values()];
  }

  #build(): void {
    this.#entries.clear();
    const own = this.#sections().filter(({ parent }) => parent === "");
    this.root.replaceChildren(this.#general, ...own.flatMap((section) => (section.isList ? this.#list(section, this.#document, "") : [this.#table(section, section.name, section.name === "" ? this.#document : this.#own(section.name))])));
  }

  /// The table of this name; made where the document has none.
  #own(name: string): Table {
    this.#document[name] ??= {};
    return this.#document[name] as Table;
  }

  /// `owner` has the list; `path` is what stands before its name, "" or "recording[1].".
  #list(section: Section, owner: Table, path: string): HTMLElement[] {
    const tables = listIn(owner, section.name);
    const full = `${path}${section.name}`;
    const inside = this.#sections().filter(({ parent, isList }) => isList && parent === section.name);
    const add = el("button", { type: "button", "data-add": full }, `Add ${section.name}`);
    add.addEventListener("click", () => {
      owner[section.name] = [...tables, {}];
      this.#build();
      this.#changed();
      this.root.querySelector<HTMLElement>(`[data-key="${full}[${tables.length + 1}].${placeOf(section.keys[0]!.name).key}"]`)?.focus();
    });
    return [
      ...tables.map((table, i) => {
        const title = `${full}[${i + 1}]`;
        const made = this.#table(section, title, table);
        const remove = el("button", { type: "button", "data-remove": title }, `Remove ${section.name} ${i + 1}`);
        remove.addEventListener("click", () => {
          owner[section.name] = tables.filter((_, k) => k !== i);
          this.#build();
          this.#changed();
        });
        made.append(...inside.flatMap((one) => this.#list(one, table, `${title}.`)), remove);
        return made;
      }),
      el("p", {}, add),
    ];
  }

  #table(section: Section, title: string, table: Table): HTMLElement {
    return el("fieldset", { class: "row" }, el("legend", {}, title === "" ? "protocol" : title), ...section.keys.map((key) => this.#entry(key, title, table)));
  }

  #entry(key: ProtocolKey, title: string, table: Table): HTMLElement {
    const { key: name } = placeOf(key.name);
    const full = title === "" ? name : `${title}.${name}`;
    const id = `field-${full.replace(/[^a-zA-Z0-9]/g, "-")}`;
    const message = el("small", { id: `${id}-message`, class: "bad" });
    const field = fieldOf(key, enteredText(table[name]), { id, "data-key": full, "aria-describedby": message.id });
    field.addEventListener("input", () => {
      const value: Value | undefined = valueOf(field.value, widgetOf(key));
      if (value === undefined) delete table[name];
      else table[name] = value;
      this.#changed();
    });
    this.#entries.set(full, { field, message });
    const hint = `${key.expected}${key.preset && key.preset !== "none" ? `; ${key.preset} if it is left out` : key.is_needed ? "" : "; may be left out"}`;
    return el("label", { class: widgetOf(key) === "text" ? "wide" : undefined }, `${name}${key.is_needed ? " *" : ""}`, field, el("small", { class: "faint" }, hint), message);
  }
}

function fieldOf(key: ProtocolKey, value: string, attributes: Record<string, string>): Field {
  const widget = widgetOf(key);
  if (widget !== "flag" && widget !== "choice") return el("input", { ...attributes, value, inputmode: widget === "number" ? "decimal" : undefined, placeholder: key.is_needed ? "needed" : key.preset, autocomplete: "off" });
  const choices = widget === "flag" ? ["true", "false"] : choicesOf(key);
  const select = el("select", attributes, el("option", { value: "" }, key.is_needed ? "choose…" : `left out (${key.preset})`), ...choices.map((choice) => el("option", { value: choice }, choice)));
  if (value !== "" && !choices.includes(value)) select.append(el("option", { value }, value));
  select.value = value;
  return select;
}
