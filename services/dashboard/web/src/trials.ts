// The trials of the session on display: the current one, and the verdicts on earlier ones.

import {
  type RigDescription,
  RigMode,
  type RigState,
  type SessionState,
  type TrialOutcome,
  type TrialProgram,
  type TrialVerdict,
} from "./contract";
import { el, facts, panel, setText, type Fact } from "./dom";
import { hex, modeNames, nameOf, trialPhaseNames } from "./names";

/// Keeps the messages of every session, because those of an older session may arrive after those of the one on display.
export class Trials {
  readonly current = panel("Current trial", "trial");
  readonly verdicts: { root: HTMLElement; age: HTMLElement };
  #facts = el("dl", { class: "facts" });
  #body = el("tbody", { id: "verdicts" });
  #outcomes = new Map<string, TrialOutcome>();
  #verdicts = new Map<string, TrialVerdict>();
  #program?: TrialProgram;
  #rig?: RigDescription;
  #session = "";
  #isChanged = true;

  constructor() {
    this.current.root.append(this.#facts);
    const head = ["Trial", "Posture", "Verdict", "Reason"].map((name) => el("th", { scope: "col" }, name));
    const table = el("table", {}, el("thead", {}, el("tr", {}, ...head)), this.#body);
    this.verdicts = panel("Verdicts", "verdict-panel", el("div", { class: "scroll", tabindex: 0 }, table));
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

  #follow(program: TrialProgram): void {
    if (hex(program.session_id) !== this.#session) return;
    if (!this.#program || program.attempt >= this.#program.attempt) this.#program = program;
  }

  /// `phase`: of the newest sample in a trial. A page opened during a trial has not received its command.
  renderCurrent(rig: RigState | undefined, session: SessionState | undefined, phase: number | undefined, thinned: number): void {
    const attempt = rig?.mode === RigMode.RIG_IN_TRIAL ? (session?.attempts ?? 0) : 0;
    const program = this.#program?.attempt === attempt ? this.#program : undefined;
    facts(this.#facts, [
      ...(attempt > 0 ? [["Attempt", String(attempt)] as Fact] : []),
      ...(program ? programFacts(program) : attempt > 0 ? [["At", session?.posture ?? "–"] as Fact] : []),
      ...(rig ? rigFacts(rig, phase, this.#rig) : []),
      ...(thinned > 0 ? [["Thinned", `${thinned} live messages left out for slow pages`, "warn"] as Fact] : []),
    ]);
  }

  renderVerdicts(): void {
    if (!this.#isChanged) return;
    this.#isChanged = false;
    const shown = [...this.#verdicts.values()]
      .filter((verdict) => hex(verdict.session_id) === this.#session)
      .sort((a, b) => b.attempt - a.attempt);
    const rejected = shown.filter((verdict) => !verdict.is_valid).length;
    setText(this.verdicts.age, shown.length > 0 ? `${shown.length} judged, ${rejected} rejected` : "none yet");
    this.#body.replaceChildren(...shown.map((verdict) => verdictRow(verdict, this.#outcomes.get(hex(verdict.trial_id)))));
  }
}

function programFacts(program: TrialProgram): Fact[] {
  if (program.recording_index >= 0) return [["Recording", `${program.recording_index + 1}`]];
  const bias = Math.hypot(program.bias_N[0]!, program.bias_N[1]!);
  return [
    ["At", `${program.posture}, set ${program.set_number}`],
    ["Push", `${(1000 * program.amplitude_m).toFixed(1)} mm towards ${program.direction_deg.toFixed(0)}°`],
    ...(bias > 0
      ? [["Bias force", `${program.bias_N[0]!.toFixed(2)}, ${program.bias_N[1]!.toFixed(2)} N`] as Fact]
      : []),
    ...(program.instruction ? [["Instruction", program.instruction] as Fact] : []),
  ];
}

function rigFacts(rig: RigState, phase: number | undefined, description: RigDescription | undefined): Fact[] {
  return [
    ["Rig", nameOf(modeNames, rig.mode), rig.mode === RigMode.RIG_HELD ? "bad" : undefined],
    ...(phase !== undefined ? [["Phase", nameOf(trialPhaseNames, phase)] as Fact] : []),
    ["Samples", `${rig.next_sequence}, ${rig.received_through} of them archived`],
    ["Overruns", String(rig.overruns), rig.overruns > 0n ? "warn" : undefined],
    ...(rig.held_because ? [["Held", rig.held_because, "bad"] as Fact] : []),
    ...(rig.fault ? [["Fault", rig.fault, "bad"] as Fact] : []),
    ...(description?.resumes_unattended
      ? [["Unattended", "goes on by itself after a fault; moves nothing real", "warn"] as Fact]
      : []),
    ...(description?.limits_off.length ? [["Limits off", description.limits_off.join(", "), "bad"] as Fact] : []),
  ];
}

function verdictRow(verdict: TrialVerdict, outcome: TrialOutcome | undefined): HTMLElement {
  return el(
    "tr",
    {},
    el("td", {}, String(verdict.attempt)),
    el("td", {}, outcome?.program.posture ?? ""),
    el("td", { class: verdict.is_valid ? "good" : "bad" }, verdict.is_valid ? "valid" : "rejected"),
    el("td", {}, verdict.detail.replace(/^valid: /, "")), // of a rejected trial it names each reason
  );
}
