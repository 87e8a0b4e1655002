// Notes and markers of the running session: a line to write, buttons for what is noted often, and what has been noted.

import type { SessionNote } from "./contract";
import { el, panel, setText } from "./dom";
import { hex } from "./names";

const quick = ["moved", "talked", "coughed", "distracted", "tired", "break"];
export const LONGEST_TEXT = 500; // bytes that the gateway takes

export interface RemarkActions {
  ask: (request: string, fields: Record<string, unknown>) => Promise<boolean>;
  say: (text: string, isBad?: boolean) => void;
}

export class Remarks {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #actions: RemarkActions;
  #notes = new Map<string, SessionNote>();
  #attempts = new Map<string, number>(); // of trials
  #session = "";
  #reason = "not connected";
  #text = el("input", { id: "note-text", maxlength: LONGEST_TEXT, autocomplete: "off", "aria-keyshortcuts": "Alt+N", title: "Write a note (Alt+N)" });
  #body = el("tbody", { id: "notes" });
  #isChanged = true;

  constructor(actions: RemarkActions) {
    this.#actions = actions;
    const form = el("form", { class: "row remark", "aria-label": "Note" }, el("label", {}, "Note (Alt+N)", this.#text), el("button", { type: "submit", id: "note" }, "Note"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#write();
    });
    const markers = el("div", { class: "row quick", role: "group", "aria-label": "Markers" });
    for (const text of quick) {
      const button = el("button", { type: "button", "data-marker": text, title: `Marks now: ${text}` }, text);
      button.addEventListener("click", () => void this.#send(text, "marker"));
      markers.append(button);
    }
    const head = ["Time (UTC)", "Trial", "Note", "By"].map((name) => el("th", { scope: "col" }, name));
    const table = el("table", {}, el("thead", {}, el("tr", {}, ...head)), this.#body);
    const made = panel("Notes", "note-panel", form, markers, el("div", { class: "scroll steady", tabindex: 0, role: "group", "aria-label": "Notes" }, table));
    this.root = made.root;
    this.#age = made.age;
    document.addEventListener("keydown", (event) => {
      if (!event.altKey || event.ctrlKey || event.code !== "KeyN") return;
      event.preventDefault();
      this.#text.focus();
    });
  }

  /// `reason`: why nothing can be noted now; empty where it can.
  allow(reason: string): void {
    this.#reason = reason;
  }

  showSession(session: string): void {
    if (session === this.#session) return;
    this.#session = session;
    this.#isChanged = true;
  }

  /// So that a note's trial has a number.
  trial(id: string, attempt: number): void {
    if (this.#attempts.get(id) === attempt) return;
    this.#attempts.set(id, attempt);
    this.#isChanged = true;
  }

  add(note: SessionNote): void {
    this.#notes.set(hex(note.note_id), note);
    this.#isChanged = true;
  }

  async #write(): Promise<void> {
    if (await this.#send(this.#text.value.trim(), "note")) this.#text.value = "";
  }

  async #send(text: string, note_kind: string): Promise<boolean> {
    if (this.#reason) return this.#actions.say(`Nothing can be noted now: ${this.#reason}.`, true), false;
    if (text === "") return this.#actions.say("Note: write what is to be noted first.", true), false;
    return this.#actions.ask("note", { text, note_kind });
  }

  render(): void {
    if (!this.#isChanged) return;
    this.#isChanged = false;
    const shown = [...this.#notes.values()].filter((note) => hex(note.session_id) === this.#session).sort((a, b) => Number(b.written_ns - a.written_ns));
    setText(this.#age, shown.length > 0 ? `${shown.length} in this session` : "none yet");
    this.#body.replaceChildren(...shown.map((note) => noteRow(note, this.#attempts.get(hex(note.trial_id)))));
  }
}

const isOfNone = (id: Uint8Array): boolean => id.every((byte) => byte === 0);

export function noteRow(note: SessionNote, attempt: number | undefined): HTMLElement {
  const trial = isOfNone(note.trial_id) ? "–" : attempt === undefined ? "?" : String(attempt);
  return el(
    "tr",
    {},
    el("td", { class: "time" }, new Date(Number(note.written_ns / 1_000_000n)).toISOString().slice(11, 19)),
    el("td", {}, trial),
    el("td", { class: "long" }, note.kind === "marker" ? `▸ ${note.text}` : note.text),
    el("td", { class: "faint long" }, note.written_by),
  );
}
