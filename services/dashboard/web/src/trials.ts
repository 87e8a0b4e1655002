// The trials of the session on display: the current one, and the verdicts on earlier ones.

import {
  type RigDescription,
  RigMode,
  type RigState,
  type SessionState,
  type TrialOutcome,
  type TrialProgram,
  type TrialReview,
  type TrialVerdict,
} from "./contract";
import { el, facts, panel, setText } from "./dom";
import { hex, modeNames, nameOf, trialPhaseNames } from "./names";
import { isRejected, keepNewest, verdictWhy, verdictWord } from "./trial_words";

/// Keeps the messages of every session, because those of an older session may arrive after those of the one on display.
export class Trials {
  readonly current = panel("Current trial", "trial");
  readonly verdicts: { root: HTMLElement; age: HTMLElement };
  #facts = el("dl", { class: "facts steady" });
  #body = el("tbody", { id: "verdicts" });
  #outcomes = new Map<string, TrialOutcome>();
  #verdicts = new Map<string, TrialVerdict>();
  #reviews = new Map<string, TrialReview>();
  #program?: TrialProgram;
  #rig?: RigDescription;
  #session = "";
  #isChanged = true;
  #chosen = ""; // trial's id; empty: the newest

  constructor() {
    this.current.root.append(this.#facts);
    const head = ["Trial", "Posture", "Verdict", "Reason"].map((name) => el("th", { scope: "col" }, name));
    const table = el("table", {}, el("thead", {}, el("tr", {}, ...head)), this.#body);
    this.verdicts = panel("Verdicts", "verdict-panel", el("div", { class: "scroll steady", tabindex: 0, role: "group", "aria-label": "Verdicts" }, table));
  }

  setRig(description: RigDescription): void {
    this.#rig = description;
  }

  showSession(session: string): void {
    if (session === this.#session) return;
    this.#session = session;
    this.#isChanged = true;
    this.#program = undefined;
    for (const { program } of this.#outcomes.values()) this.#follow(program);
  }

  command(program: TrialProgram): void {
    this.#follow(program);
  }

  outcome(outcome: TrialOutcome): void {
    this.#outcomes.set(hex(outcome.trial_id), outcome);
    this.#isChanged = true;
    this.#follow(outcome.program);
  }

  verdict(verdict: TrialVerdict): void {
    this.#verdicts.set(hex(verdict.trial_id), verdict);
    this.#isChanged = true;
  }

  review(review: TrialReview): void {
    keepNewest(this.#reviews, hex(review.trial_id), review);
    this.#isChanged = true;
  }

  #follow(program: TrialProgram): void {
    if (hex(program.session_id) !== this.#session) return;
    if (!this.#program || program.attempt >= this.#program.attempt) this.#program = program;
  }

  /// `phase`: of the newest sample in a trial. A page opened during a trial has not received its command. The lines are
  /// the same at all times, so that nothing moves.
  renderCurrent(rig: RigState | undefined, session: SessionState | undefined, phase: number | undefined, thinned: number): void {
    const attempt = rig?.mode === RigMode.RIG_IN_TRIAL ? (session?.attempts ?? 0) : 0;
    const program = this.#program?.attempt === attempt ? this.#program : undefined;
    facts(this.#facts, [
      ["Attempt", attempt > 0 ? String(attempt) : "–"],
      ["At", program ? placeOf(program) : attempt > 0 ? (session?.posture ?? "–") : "–"],
      ["Push", program ? pushOf(program) : "–"],
      ["Bias force", program && isBiased(program) ? `${program.bias_N[0]!.toFixed(2)}, ${program.bias_N[1]!.toFixed(2)} N` : "–"],
      ["Instruction", program?.instruction || "–"],
      ["Rig", rig ? nameOf(modeNames, rig.mode) : "–", rig?.mode === RigMode.RIG_HELD ? "bad" : undefined],
      ["Phase", phase !== undefined ? nameOf(trialPhaseNames, phase) : "–"],
      ["Samples", rig ? `${rig.next_sequence}, ${rig.received_through} of them archived` : "–"],
      ["Overruns", rig ? String(rig.overruns) : "–", rig && rig.overruns > 0n ? "warn" : undefined],
      ["To note", notesOf(this.#rig, thinned) || "–", this.#rig?.limits_off.length ? "bad" : thinned > 0 ? "warn" : undefined],
    ]);
  }

  renderVerdicts(): void {
    if (!this.#isChanged) return;
    this.#isChanged = false;
    const shown = [...this.#verdicts.values()]
      .filter((verdict) => hex(verdict.session_id) === this.#session)
      .sort((a, b) => b.attempt - a.attempt);
    const rejected = shown.filter((verdict) => isRejected(verdict, this.#reviews.get(hex(verdict.trial_id)))).length;
    setText(this.verdicts.age, shown.length > 0 ? `${shown.length} judged, ${rejected} rejected` : "none yet");
    this.#body.replaceChildren(...shown.map((verdict) => this.#row(verdict)));
  }

  #row(verdict: TrialVerdict): HTMLElement {
    const id = hex(verdict.trial_id);
    const row = verdictRow(verdict, this.#outcomes.get(id), this.#reviews.get(id), () => {
      this.#chosen = this.#chosen === id ? "" : id;
      this.#isChanged = true;
    });
    row.classList.toggle("chosen", id === this.#chosen);
    row.querySelector("button")!.setAttribute("aria-pressed", String(id === this.#chosen));
    return row;
  }

  /// The trial on display, the newest or the chosen one, and those before it at any posture, the nearest first.
  shown(): { verdict: TrialVerdict; review?: TrialReview; program?: TrialProgram; before: string[] } | undefined {
    const all = [...this.#verdicts.values()]
      .filter((verdict) => hex(verdict.session_id) === this.#session)
      .sort((a, b) => b.attempt - a.attempt);
    const i = Math.max(0, all.findIndex((verdict) => hex(verdict.trial_id) === this.#chosen));
    const verdict = all[i];
    if (!verdict) return undefined;
    const id = hex(verdict.trial_id);
    return { verdict, review: this.#reviews.get(id), program: this.#outcomes.get(id)?.program, before: all.slice(i + 1).map((one) => hex(one.trial_id)) };
  }
}

const placeOf = (program: TrialProgram): string =>
  program.recording_index >= 0 ? `recording ${program.recording_index + 1}` : `${program.posture}, set ${program.set_number}`;

const pushOf = (program: TrialProgram): string =>
  program.recording_index >= 0 ? "–" : `${(1000 * program.amplitude_m).toFixed(1)} mm towards ${program.direction_deg.toFixed(0)}°`;

const isBiased = (program: TrialProgram): boolean => Math.hypot(program.bias_N[0]!, program.bias_N[1]!) > 0;

function notesOf(rig: RigDescription | undefined, thinned: number): string {
  return [
    ...(rig?.limits_off.length ? [`limits off: ${rig.limits_off.join(", ")}`] : []),
    ...(rig?.resumes_unattended ? ["resumes by itself after a fault; moves nothing real"] : []),
    ...(thinned > 0 ? [`${thinned} live messages left out for slow pages`] : []),
  ].join("; ");
}

function verdictRow(verdict: TrialVerdict, outcome: TrialOutcome | undefined, review: TrialReview | undefined, choose: () => void): HTMLElement {
  const button = el("button", { type: "button", class: "sort", title: "Show this trial above" }, String(verdict.attempt));
  button.addEventListener("click", choose);
  return el(
    "tr",
    {},
    el("td", {}, button),
    el("td", {}, outcome?.program.posture ?? ""),
    el("td", { class: isRejected(verdict, review) ? "bad" : "good" }, verdictWord(verdict, review)),
    el("td", {}, verdictWhy(verdict, review)), // of a rejected trial it names each reason
  );
}
