// What an operator does with the trial on display: reject it for a reason, have it repeated, or note something about it.

import type { Control } from "./desk_state";
import { el } from "./dom";
import { LONGEST_TEXT, type RemarkActions } from "./remarks";
import { REPEAT } from "./trial_words";

export interface TrialChoice {
  id: string;
  attempt: number;
  /// Why it cannot be rejected; empty where it can.
  settled: string;
}

export class TrialActions {
  readonly root: HTMLElement;
  #actions: RemarkActions;
  #trial?: TrialChoice;
  #reason = "not connected";
  #text = el("input", { id: "trial-text", maxlength: LONGEST_TEXT, autocomplete: "off" });

  constructor(actions: RemarkActions) {
    this.#actions = actions;
    const button = (id: string, name: string, title: string, act: () => Promise<boolean>): HTMLElement => {
      const made = el("button", { type: "button", id, title }, name);
      made.addEventListener("click", () => void act());
      return made;
    };
    this.root = el(
      "div",
      { class: "row remark", role: "group", "aria-label": "This trial" },
      el("label", {}, "Reason, or note", this.#text),
      button("reject-trial", "Reject", "Leaves this trial out of every estimate, and runs it again", () => this.#reject()),
      button("repeat-trial", "Repeat", `Rejects this trial with the reason “${REPEAT}”: it is left out and run again`, () => this.#send("reject_trial", REPEAT)),
      button("note-trial", "Note", "Notes this about the trial", () => this.#note()),
    );
  }

  /// `reason`: why the session takes no remark now; empty where it does.
  show(trial: TrialChoice | undefined, reason: string): void {
    this.#trial = trial;
    this.#reason = reason;
  }

  async #reject(): Promise<boolean> {
    const text = this.#text.value.trim();
    if (text === "") {
      this.#text.focus();
      return this.#actions.say("Reject: write the reason first.", true), false;
    }
    return this.#send("reject_trial", text);
  }

  async #note(): Promise<boolean> {
    const text = this.#text.value.trim();
    if (text === "") {
      this.#text.focus();
      return this.#actions.say("Note: write what is to be noted first.", true), false;
    }
    return this.#send("note", text);
  }

  async #send(request: "reject_trial" | "note", text: string): Promise<boolean> {
    const trial = this.#trial;
    const why = this.#reason || (!trial ? "no trial is shown" : request === "reject_trial" ? trial.settled : "");
    if (why || !trial) return this.#actions.say(`${request === "note" ? "Note" : "Rejection"} is not possible now: ${why}.`, true), false;
    const isDone = await this.#actions.ask(request, { trial_id: trial.id, text });
    if (isDone) this.#text.value = "";
    return isDone;
  }
}

/// Whether remarks are taken: while a session goes on.
export const remarkReason = (reasons: Record<Control, string>): string => reasons.abort;
