// The form that starts a session: subject, operator, protocol from the list or from a file, seed. It stays where it is
// while a session runs, and says why it cannot start another.

import { getJson } from "./access";
import { randomId } from "./connection";
import { setReason } from "./controls";
import { el, panel, setText } from "./dom";
import { keepOperatorName, LONGEST_NAME, operatorName } from "./operator_name";
import { drawnSeed, isOfOneSession, knownSubjects, subjectProblem } from "./start_rules";

const USUAL = "unloaded";
const NEW = "";

export interface StartActions {
  ask: (request: string, fields: Record<string, unknown>) => Promise<boolean>;
  say: (text: string, isBad?: boolean) => void;
}

type Source = "list" | "file";

export class StartForm {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #actions: StartActions;
  #protocols = new Map<string, string>();
  #reason = "";
  #known = el("select", { id: "known-subject" }, el("option", { value: NEW }, "new…"));
  #subject = el("input", { id: "subject", value: "sub-01", required: true, size: 10, maxlength: 64, "aria-describedby": "start-problem" });
  #operator = el("input", { id: "operator", value: operatorName(), size: 12, maxlength: LONGEST_NAME, autocomplete: "name" });
  #fromList = el("input", { type: "radio", name: "source", value: "list", id: "from-list", checked: true });
  #fromFile = el("input", { type: "radio", name: "source", value: "file", id: "from-file" });
  #protocol = el("select", { id: "protocol", "aria-label": "Protocol of the list" });
  #file = el("input", { id: "protocol-file", type: "file", accept: ".toml", "aria-label": "Protocol's file" });
  #seed = el("input", { id: "seed", type: "number", min: 0, step: 1, value: drawnSeed(), required: true, class: "short" });
  #problem = el("p", { id: "start-problem", class: "bad line" });
  #why = el("small", { id: "start-why" });
  #start = el("button", { id: "start", type: "submit", "aria-disabled": "true", "aria-describedby": "start-why" }, el("span", {}, "Start"), this.#why);

  constructor(actions: StartActions) {
    this.#actions = actions;
    const draw = el("button", { type: "button", id: "draw-seed" }, "Draw");
    draw.addEventListener("click", () => this.#drawSeed());
    const form = el(
      "form",
      { class: "start-form", id: "start-form", "aria-label": "Start a session" },
      el(
        "div",
        { class: "row" },
        el("label", {}, "Subject", this.#known),
        el("label", {}, "Id of a new one", this.#subject),
        el("label", {}, "Operator", this.#operator),
        el("label", {}, "Seed", this.#seed),
        draw,
      ),
      el(
        "fieldset",
        { class: "row" },
        el("legend", {}, "Protocol"),
        el("label", { class: "pick" }, this.#fromList, "list"),
        this.#protocol,
        el("label", { class: "pick" }, this.#fromFile, "file"),
        this.#file,
      ),
      el("div", { class: "row" }, this.#start, this.#problem),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#submit();
    });
    for (const source of [this.#fromList, this.#fromFile]) source.addEventListener("change", () => this.#showSource());
    this.#protocol.addEventListener("change", () => this.#choose("list"));
    this.#file.addEventListener("change", () => this.#choose("file"));
    this.#known.addEventListener("change", () => this.#showSubject());
    this.#subject.addEventListener("input", () => this.#showSubject());
    this.#operator.addEventListener("input", () => keepOperatorName(this.#operator.value));
    const made = panel("Start a session", "start-panel", form);
    this.root = made.root;
    this.#age = made.age;
    this.#showSource();
    this.#showSubject();
  }

  async load(): Promise<void> {
    await Promise.all([this.#loadProtocols(), this.#loadSubjects()]);
  }

  async #loadProtocols(): Promise<void> {
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

  async #loadSubjects(): Promise<void> {
    try {
      const subjects = knownSubjects(await getJson<{ subject: string }[]>("/api/sessions"));
      const chosen = this.#known.value;
      const options = subjects.map(({ id, sessions }) =>
        el("option", { value: id }, `${id} (${sessions} ${sessions === 1 ? "session" : "sessions"})`),
      );
      this.#known.replaceChildren(el("option", { value: NEW }, "new…"), ...options);
      if (subjects.some(({ id }) => id === chosen)) this.#known.value = chosen;
      this.#showSubject();
    } catch (error) {
      this.#actions.say(`The archive's subjects cannot be read: ${(error as Error).message}`, true);
    }
  }

  get #source(): Source {
    return this.#fromFile.checked ? "file" : "list";
  }

  #choose(source: Source): void {
    (source === "file" ? this.#fromFile : this.#fromList).checked = true;
    this.#showSource();
  }

  /// One source or the other: a file that was chosen before the list is forgotten.
  #showSource(): void {
    const isFile = this.#source === "file";
    if (!isFile) this.#file.value = "";
    this.#protocol.classList.toggle("idle", isFile);
    this.#file.classList.toggle("idle", !isFile);
  }

  #showSubject(): void {
    const isNew = this.#known.value === NEW;
    this.#subject.disabled = !isNew;
    setText(this.#problem, isNew ? subjectProblem(this.#subject.value) : "");
  }

  #drawSeed(): void {
    this.#seed.value = String(drawnSeed());
  }

  /// `reason`: why a session cannot start; empty where it can.
  show(reason: string, isNext: boolean): void {
    this.#reason = reason;
    setReason(this.#start, this.#why, reason.length > 24 ? "not ready" : reason);
    this.#start.classList.toggle("main", isNext && reason === "");
    setText(this.#age, reason);
    this.#age.className = reason && reason !== "a session runs" ? "age old" : "age";
  }

  async #submit(): Promise<void> {
    const { say } = this.#actions;
    if (this.#reason) return say(`Start is not possible now: ${this.#reason}.`, true);
    const subject = this.#known.value || this.#subject.value;
    const problem = this.#known.value === NEW ? subjectProblem(subject) : "";
    if (problem) return say(problem, true);
    const text = await this.#protocolText();
    if (!text) return;
    const isDone = await this.#actions.ask("start", { session_id: randomId(), protocol_toml: text, subject, seed: Number(this.#seed.value) });
    if (!isDone) return;
    this.#drawSeed();
    await this.#loadSubjects();
  }

  async #protocolText(): Promise<string | undefined> {
    const { say } = this.#actions;
    if (this.#source === "list") {
      const text = this.#protocols.get(this.#protocol.value);
      if (!text) say("Protocol: nothing is chosen; expected one of the list, or a file.", true);
      return text;
    }
    const chosen = this.#file.files?.[0];
    if (!chosen) {
      say("Protocol: no file is chosen; expected a file, or one of the list.", true);
      return undefined;
    }
    const text = await chosen.text();
    if (text) return text;
    say(`Protocol: ${chosen.name} is empty; expected a protocol in TOML.`, true);
    return undefined;
  }
}
