// The form that starts a session: subject with what is known of it, operator, study, protocol from the list or from a file,
// seed, pilot mode, and what the session would do. It stays where it is while a session runs, and says why it cannot start
// another.

import { getJson } from "./access";
import { randomId } from "./connection";
import { setReason } from "./controls";
import { el, panel, setText } from "./dom";
import { editedProtocol } from "./edited_protocol";
import { keepOperatorName, LONGEST_NAME, operatorName } from "./operator_name";
import { LatestCheck } from "./protocol_check";
import { checkLine, extremeLine, type ProtocolCheck } from "./protocol_words";
import { drawnSeed, isOfOneSession, studyNames, subjectProblem, subjectText, type KnownSubject } from "./start_rules";
import { enteredOf, factsOf, subjectFields, type Facts } from "./subject_facts";

const USUAL = "unloaded";
const NEW = "";
const NO_STUDY = "";
const CHECK_AFTER_MS = 300;

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
  #subjects: KnownSubject[] = [];
  #reason = "";
  #check = new LatestCheck();
  #checkTimer = 0;
  #known = el("select", { id: "known-subject" }, el("option", { value: NEW }, "new…"));
  #subject = el("input", { id: "subject", value: "sub-01", required: true, size: 10, maxlength: 64, "aria-describedby": "start-problem" });
  #facts = new Map<string, HTMLInputElement | HTMLSelectElement>();
  #operator = el("input", { id: "operator", value: operatorName(), size: 12, maxlength: LONGEST_NAME, autocomplete: "name" });
  #study = el("select", { id: "study" }, el("option", { value: NO_STUDY }, "none"));
  #pilot = el("input", { type: "checkbox", id: "pilot" });
  #fromList = el("input", { type: "radio", name: "source", value: "list", id: "from-list", checked: true });
  #fromFile = el("input", { type: "radio", name: "source", value: "file", id: "from-file" });
  #protocol = el("select", { id: "protocol", "aria-label": "Protocol of the list" });
  #file = el("input", { id: "protocol-file", type: "file", accept: ".toml", "aria-label": "Protocol's file" });
  #preview = el("p", { id: "preview", class: "line", role: "status" });
  #extremes = el("ul", { id: "extremes", class: "plain" });
  #seed = el("input", { id: "seed", type: "number", min: 0, step: 1, value: drawnSeed(), required: true, class: "short" });
  #problem = el("p", { id: "start-problem", class: "bad line" });
  #why = el("small", { id: "start-why" });
  #start = el("button", { id: "start", type: "submit", "aria-disabled": "true", "aria-describedby": "start-why" }, el("span", {}, "Start"), this.#why);

  constructor(actions: StartActions) {
    this.#actions = actions;
    const made = panel("Start a session", "start-panel", this.#build());
    this.root = made.root;
    this.#age = made.age;
    this.#listen();
    this.#showSource();
    this.#showSubject();
  }

  #build(): HTMLFormElement {
    const draw = el("button", { type: "button", id: "draw-seed" }, "Draw");
    draw.addEventListener("click", () => this.#drawSeed());
    const form = el(
      "form",
      { class: "start-form", id: "start-form", "aria-label": "Start a session" },
      el("div", { class: "row" }, el("label", {}, "Subject", this.#known), el("label", {}, "Id of a new one", this.#subject), el("label", {}, "Operator", this.#operator)),
      el("details", { id: "subject-details" }, el("summary", {}, "About the subject"), el("div", { class: "row" }, ...subjectFields.map((field) => this.#factField(field)))),
      el(
        "fieldset",
        { class: "row" },
        el("legend", {}, "Protocol"),
        el("label", { class: "pick" }, this.#fromList, "list"),
        this.#protocol,
        el("label", { class: "pick" }, this.#fromFile, "file"),
        this.#file,
        this.#preview,
        el("details", { id: "extremes-details" }, el("summary", {}, "Extremes and limits"), this.#extremes),
      ),
      el(
        "div",
        { class: "row" },
        el("label", {}, "Study", this.#study),
        el("label", {}, "Seed", this.#seed),
        draw,
        el("label", { class: "pick", title: "A rehearsal: marked in the data, no part of a study's results" }, this.#pilot, "Pilot"),
      ),
      el("div", { class: "row" }, this.#start, this.#problem),
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#submit();
    });
    return form;
  }

  #factField({ id, name, choices }: (typeof subjectFields)[number]): HTMLElement {
    const field = choices
      ? el("select", { id }, el("option", { value: "" }, "not known"), ...choices.map((choice) => el("option", { value: choice }, choice)))
      : el("input", { id, inputmode: "decimal", size: 6, maxlength: 12, placeholder: "not known", class: "short" });
    this.#facts.set(id, field);
    return el("label", {}, name, field);
  }

  #listen(): void {
    for (const source of [this.#fromList, this.#fromFile]) source.addEventListener("change", () => this.#showSource());
    this.#protocol.addEventListener("change", () => this.#choose("list"));
    this.#file.addEventListener("change", () => this.#choose("file"));
    this.#known.addEventListener("change", () => this.#recall());
    this.#subject.addEventListener("input", () => this.#showSubject());
    this.#seed.addEventListener("input", () => this.#checkSoon());
    this.#operator.addEventListener("input", () => keepOperatorName(this.#operator.value));
  }

  async load(): Promise<void> {
    await Promise.all([this.#loadProtocols(), this.#loadSubjects()]);
  }

  async #loadProtocols(): Promise<void> {
    try {
      const list = await getJson<{ name: string; text: string }[]>("/api/protocols");
      const chosen = this.#protocol.value || USUAL;
      this.#protocols = new Map(list.filter(isOfOneSession).map(({ name, text }) => [name, text]));
      const edited = editedProtocol();
      if (edited) this.#protocols.set(`edited: ${edited.name}`, edited.text);
      this.#protocol.replaceChildren(...[...this.#protocols.keys()].map((name) => el("option", { value: name }, name)));
      if (this.#protocols.has(chosen)) this.#protocol.value = chosen;
      const study = this.#study.value;
      this.#study.replaceChildren(el("option", { value: NO_STUDY }, "none"), ...studyNames(list).map((name) => el("option", { value: name }, name)));
      this.#study.value = study;
      this.#takeAddress();
      this.#checkSoon();
    } catch (error) {
      this.#actions.say(`The protocols cannot be read: ${(error as Error).message}`, true);
    }
  }

  /// The studies' page sends here with what is due: /#subject=s01&study=cohort&protocol=unloaded&seed=1.
  #takeAddress(): void {
    const due = new URLSearchParams(location.hash.slice(1));
    const [subject, study, protocol, seed] = ["subject", "study", "protocol", "seed"].map((name) => due.get(name) ?? "");
    if (!subject) return;
    history.replaceState(null, "", location.pathname);
    this.#known.value = NEW;
    this.#subject.value = subject;
    this.#study.value = study!;
    if (this.#protocols.has(protocol!)) this.#protocol.value = protocol!;
    else this.#actions.say(`The study's protocol "${protocol}" is not in the list; choose its file.`, true);
    if (seed) this.#seed.value = seed;
    this.#choose("list");
    this.#showSubject();
    this.#recall(subject);
    this.root.scrollIntoView();
    this.#start.focus();
  }

  async #loadSubjects(): Promise<void> {
    try {
      const subjects = await getJson<KnownSubject[]>("/api/subjects");
      this.#subjects = subjects;
      const chosen = this.#known.value;
      const options = subjects.map((known) => el("option", { value: known.subject }, subjectText(known)));
      this.#known.replaceChildren(el("option", { value: NEW }, "new…"), ...options);
      if (subjects.some(({ subject }) => subject === chosen)) this.#known.value = chosen;
      this.#showSubject();
    } catch (error) {
      this.#actions.say(`The archive's subjects cannot be read: ${(error as Error).message}`, true);
    }
  }

  /// What the archive knows of the subject. A new one begins with empty fields.
  #recall(subject = this.#known.value): void {
    this.#showSubject();
    this.#enter(this.#subjects.find((known) => known.subject === subject)?.subject_facts ?? {});
  }

  #enter(facts: Facts): void {
    for (const [id, text] of Object.entries(enteredOf(facts))) this.#facts.get(id)!.value = text;
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
    this.#checkSoon();
  }

  #showSubject(): void {
    const isNew = this.#known.value === NEW;
    this.#subject.disabled = !isNew;
    setText(this.#problem, isNew ? subjectProblem(this.#subject.value) : "");
  }

  #drawSeed(): void {
    this.#seed.value = String(drawnSeed());
    this.#checkSoon();
  }

  #checkSoon(): void {
    this.#check.forget();
    clearTimeout(this.#checkTimer);
    this.#checkTimer = window.setTimeout(() => void this.#checkNow(), CHECK_AFTER_MS);
  }

  /// Shows what the chosen protocol would do.
  async #checkNow(): Promise<void> {
    const text = await this.#protocolText(() => undefined);
    if (!text) return this.#showCheck(undefined);
    try {
      const found = await this.#check.of(text, Number(this.#seed.value) || 0);
      if (found) this.#showCheck(found);
    } catch (error) {
      this.#showCheck(undefined, `no preview: ${(error as Error).message}`);
    }
  }

  #showCheck(found: ProtocolCheck | undefined, otherwise = ""): void {
    setText(this.#preview, found ? checkLine(found) : otherwise);
    this.#preview.classList.toggle("bad", found !== undefined && !found.is_accepted);
    this.#extremes.replaceChildren(...(found?.preview?.extremes ?? []).map((extreme) => el("li", {}, extremeLine(extreme))));
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
    const { facts, problem: wrong } = factsOf(Object.fromEntries([...this.#facts].map(([id, field]) => [id, field.value])));
    const problem = (this.#known.value === NEW ? subjectProblem(subject) : "") || wrong;
    if (problem) return say(problem, true);
    const text = await this.#protocolText(say);
    if (!text) return;
    const isDone = await this.#actions.ask("start", {
      session_id: randomId(), protocol_toml: text, subject, seed: Number(this.#seed.value), subject_facts: facts, study: this.#study.value, is_pilot: this.#pilot.checked,
    });
    if (!isDone) return;
    this.#drawSeed();
    await this.#loadSubjects();
  }

  async #protocolText(say: StartActions["say"]): Promise<string | undefined> {
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
