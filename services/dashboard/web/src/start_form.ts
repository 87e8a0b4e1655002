// The form that starts a session: protocol, subject, seed.

import { getJson } from "./access";
import { randomId } from "./connection";
import { el, panel, setText } from "./dom";

const USUAL = "unloaded";

export interface StartActions {
  ask: (request: string, fields: Record<string, unknown>) => Promise<void>;
  say: (text: string, isBad?: boolean) => void;
}

export class StartForm {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #actions: StartActions;
  #protocols = new Map<string, string>();
  #protocol = el("select", { id: "protocol" });
  #file = el("input", { id: "protocol-file", type: "file", accept: ".toml" });
  #subject = el("input", { id: "subject", value: "sub-01", required: true, size: 10, maxlength: 128 });
  #seed = el("input", { id: "seed", type: "number", min: 0, step: 1, value: 1, required: true, class: "short" });
  #start = el("button", { id: "start", type: "submit", class: "main" }, "Start");

  constructor(actions: StartActions) {
    this.#actions = actions;
    const form = el(
      "form",
      { class: "row", id: "start-form" },
      el("label", {}, "Protocol", this.#protocol),
      el("label", {}, "or a file", this.#file),
      el("label", {}, "Subject", this.#subject),
      el("label", {}, "Seed", this.#seed),
      this.#start,
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#submit();
    });
    const made = panel("Start a session", "start-panel", form);
    this.root = made.root;
    this.#age = made.age;
  }

  async load(): Promise<void> {
    try {
      const list = await getJson<{ name: string; text: string }[]>("/api/protocols");
      const chosen = this.#protocol.value || USUAL;
      this.#protocols = new Map(list.filter(isOfOneSession).map(({ name, text }) => [name, text]));
      this.#protocol.replaceChildren(...[...this.#protocols.keys()].map((name) => el("option", { value: name }, name)));
      if (this.#protocols.has(chosen)) this.#protocol.value = chosen;
    } catch (error) {
      this.#actions.say(`The protocols cannot be read: ${(error as Error).message}`, true);
    }
  }

  /// `missing`: why a session cannot start; empty where it can.
  show(isSessionGoing: boolean, mayOperate: boolean, missing: string): void {
    const hadFocus = this.root.contains(document.activeElement);
    this.root.hidden = isSessionGoing;
    if (isSessionGoing && hadFocus) document.getElementById("pause")?.focus();
    this.#start.disabled = !mayOperate || missing !== "";
    setText(this.#age, missing);
    this.#age.className = missing ? "age old" : "age";
  }

  async #submit(): Promise<void> {
    const chosen = this.#file.files?.[0];
    const text = chosen ? await chosen.text() : this.#protocols.get(this.#protocol.value);
    if (!text) return this.#actions.say("A protocol is needed.", true);
    await this.#actions.ask("start", {
      session_id: randomId(),
      protocol_toml: text,
      subject: this.#subject.value,
      seed: Number(this.#seed.value),
    });
  }
}

/// A study is many sessions, which `tonus` runs one after another.
const isOfOneSession = ({ text }: { text: string }): boolean => !/^\s*kind\s*=\s*"study"/m.test(text);
