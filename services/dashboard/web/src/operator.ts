// The operator's page: the controls, the running session, and the services.

import { AuxiliaryTrace } from "./auxiliary_trace";
import { Connection } from "./connection";
import {
  RigMode,
  SessionPhase,
  type AuxiliaryBlock,
  type Estimate,
  type RigDescription,
  type SampleBlock,
  type SessionNote,
  type SessionState,
  type TrialOutcome,
  type TrialProgram,
  type TrialReview,
  type TrialVerdict,
} from "./contract";
import { Controls } from "./controls";
import { reasonsAgainst, stripOf } from "./desk_state";
import { el, facts, panel, setText, type Fact } from "./dom";
import { fitFor } from "./fit_choice";
import { Fresh, ageText, duration } from "./freshness";
import { robotFrame } from "./geometry";
import type { GatewayStatus } from "./gateway_messages";
import { hex, isActive, nameOf, sessionPhaseNames } from "./names";
import { Remarks } from "./remarks";
import { Roster } from "./roster";
import { buildShell } from "./shell";
import { StartForm } from "./start_form";
import { Trace } from "./trace";
import { remarkReason, TrialActions } from "./trial_actions";
import { TrialChart } from "./trial_chart";
import { TrialRecorder, type Course } from "./trial_recorder";
import { isRejected, limitsIn, verdictWord } from "./trial_words";
import { Trials } from "./trials";

const REFRESH_MS = 250;
const FAINT_TRIALS = 8;

const connection = new Connection();
const { main, say, desk } = buildShell(connection, "/");
const roster = new Roster(desk.presence);
const trials = new Trials();
const trace = new Trace();
const auxiliary = new AuxiliaryTrace();
let hasAuxiliary = false;
const recorder = new TrialRecorder();
const trialChart = new TrialChart();
let drawnTrial = "";

const samples = new Fresh<SampleBlock>();
desk.samples = samples;
const gateway = new Fresh<GatewayStatus>();

const phase = el("span", { class: "phase", id: "phase" }, "no session");
const counts = el("dl", { class: "facts steady" });
const progress = el("progress", { id: "progress", max: 1, value: 0, "aria-label": "Trials counted" });
const controls = new Controls({ ask: (request) => void ask(request, request === "clear_fault" ? holdSeen() : {}), say });
const sessionPanel = panel("Session", "session", controls.root, phase, progress, counts);
const startForm = new StartForm({ ask, say });
const remarks = new Remarks({ ask, say });
const trialActions = new TrialActions({ ask, say });
trialChart.root.querySelector("header")!.after(trialActions.root);
const estimates = new Map<string, Estimate>();
const tracePanel = panel("Hand and force", "trace-panel", trace.root);

main.append(
  el(
    "div",
    { class: "operator" },
    el("div", {}, sessionPanel.root, startForm.root, trials.current.root, roster.root),
    el("div", {}, tracePanel.root, auxiliary.root, remarks.root, trialChart.root, trials.verdicts.root),
  ),
);

// Requests

/// Whether it was done.
async function ask(name: string, fields: Record<string, unknown> = {}): Promise<boolean> {
  if (connection.state !== "connected") {
    say(`${name} was NOT sent: disconnected.`, true);
    return false;
  }
  say(`${name}: sent, waiting for the reply…`);
  const reply = await connection.request(name, fields);
  say(`${name}: ${reply.is_done ? "done" : "refused"}. ${reply.message}`, !reply.is_done);
  return reply.is_done;
}

const holdSeen = (): { hold_number: number } => ({ hold_number: desk.rig.value?.hold_number ?? 0 });

// Subscriptions

connection.subscribe<SessionState>("session/state", () => {
  if (!desk.session.value) return;
  trials.showSession(hex(desk.session.value.session_id));
  remarks.showSession(hex(desk.session.value.session_id));
});
connection.subscribe<TrialVerdict>("trial/verdict", ({ value }) => trials.verdict(value));
connection.subscribe<TrialReview>("trial/review", ({ value }) => trials.review(value));
connection.subscribe<SessionNote>("session/note", ({ value }) => {
  remarks.add(value);
  trace.addNote(value);
});
connection.subscribe<Estimate>("estimate/condition", ({ value }) => estimates.set(hex(value.estimate_id), value));
connection.subscribe<TrialOutcome>("trial/outcome", ({ value }) => {
  trials.outcome(value);
  remarks.trial(hex(value.trial_id), value.program.attempt);
  const shown = desk.session.value;
  if (shown && hex(value.program.session_id) === hex(shown.session_id)) trace.setTrial(value.program);
});
connection.subscribe<{ program: TrialProgram }>("trial/command", ({ value }) => {
  trials.command(value.program);
  trace.setTrial(value.program);
});
connection.subscribe<RigDescription>("rig/description", ({ value }) => {
  trace.setRig(value);
  trials.setRig(value);
  auxiliary.setRig(value);
  // Asked for only where there are any: what nobody looks at is not sent.
  if (value.auxiliary_channels.length > 0 && !hasAuxiliary) {
    hasAuxiliary = true;
    connection.subscribe<AuxiliaryBlock>("rig/auxiliary", (arrival) => auxiliary.add(arrival.value));
  }
});
connection.subscribe<GatewayStatus>("gateway/status", (arrival) => gateway.set(arrival));
connection.subscribe<SampleBlock>("rig/samples", (arrival) => {
  samples.set(arrival);
  trace.add(arrival.value);
  if (desk.description) recorder.add(arrival.value, desk.description, desk.pose ?? robotFrame);
});
connection.onState((state) => {
  if (state === "connected") void startForm.load();
});
document.addEventListener("tonus-token", () => void startForm.load());

// Display

function showAge(element: HTMLElement, age: number | undefined, limit: number): void {
  setText(element, ageText(age));
  element.className = age === undefined || age > limit ? "age old" : "age";
}

/// The same lines at all times.
function sessionFacts(state: SessionState | undefined): Fact[] {
  const plan = desk.plan;
  return [
    ["Trials", state ? `${state.counted} of ${state.planned} counted, ${state.rejected} rejected` : "–"],
    ["Posture", state?.posture || "–"],
    ["Remaining", state && isActive(state.phase) ? `about ${duration(state.remaining_s)}` : "–"],
    ["Subject", plan ? `${plan.subject}, protocol ${plan.protocol_name}` : "–"],
    ["Id", state ? hex(state.session_id) : "–"],
    ["Message", state?.message || "–"],
  ];
}

function showSession(): void {
  const state = desk.session.value;
  const view = desk.view();
  const strip = stripOf(view);
  setText(phase, state ? nameOf(sessionPhaseNames, state.phase) : "no session");
  phase.className = `phase ${state?.phase === SessionPhase.SESSION_FAILED ? "bad" : strip.tone === "turn" ? "warn" : ""}`;
  progress.max = Math.max(1, state?.planned ?? 1);
  progress.value = state?.counted ?? 0;
  facts(counts, sessionFacts(state));
  controls.show(view, strip.next);
  const reasons = reasonsAgainst(view);
  startForm.show(reasons.start, strip.next === "start");
  remarks.allow(remarkReason(reasons));
  // A session's state changes when something happens: its age is no fault.
  setText(sessionPanel.age, state ? `changed: ${ageText(desk.session.age)}` : "");
}

function showTrial(): void {
  const rig = desk.rig;
  const isInTrial = rig.value?.mode === RigMode.RIG_IN_TRIAL;
  const phaseNow = isInTrial ? samples.value?.samples.at(-1)?.phase : undefined;
  trials.renderCurrent(rig.value, desk.session.value, phaseNow, gateway.value?.thinned ?? 0);
  showAge(trials.current.age, rig.age, 2);
  showAge(tracePanel.age, samples.age, isInTrial ? 1 : Infinity);
}

/// Drawn anew only where another trial is shown, it is reviewed, or its onset or an estimate has become known.
function showLastTrial(): void {
  const found = trials.shown();
  const id = found ? hex(found.verdict.trial_id) : "none";
  const settled = found && isRejected(found.verdict, found.review) ? "it is rejected already" : "";
  trialActions.show(found && { id, attempt: found.verdict.attempt, settled }, remarkReason(reasonsAgainst(desk.view())));
  const course = found && recorder.course(id);
  const fitted = course && found.program && fitFor([...estimates.values()], found.program, course);
  const key = `${id} ${course ? course.times.length : 0} ${found ? verdictWord(found.verdict, found.review) : ""} ${fitted?.of ?? ""}`;
  if (key === drawnTrial) return;
  drawnTrial = key;
  const before = (found?.before ?? []).map((one) => recorder.course(one)).filter((one): one is Course => one !== undefined).slice(0, FAINT_TRIALS);
  const verdict = found?.verdict;
  const text = verdict ? [found.program?.posture ?? "", verdictWord(verdict, found.review)].filter((part) => part !== "").join(", ") : "";
  const units = { displacement: desk.description?.displacement_unit ?? "m", force: desk.description?.force_unit ?? "N" };
  const limits = units.displacement === "m" ? limitsIn(verdict?.detail ?? "") : undefined;
  trialChart.show(verdict && { attempt: verdict.attempt, text, course, limits, fit: fitted }, before, units);
}

setInterval(() => {
  roster.render(connection.state === "connected");
  showSession();
  showTrial();
  trials.renderVerdicts();
  remarks.render();
  showLastTrial();
  trace.renderValues();
  auxiliary.render();
}, REFRESH_MS);
