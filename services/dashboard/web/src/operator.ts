// The operator's page: the services, the running session, and the controls.

import { Connection } from "./connection";
import {
  RigMode,
  SessionPhase,
  type RigDescription,
  type RigState,
  type SampleBlock,
  type SessionPlan,
  type SessionState,
  type TrialOutcome,
  type TrialProgram,
  type TrialVerdict,
} from "./contract";
import { el, facts, panel, setText, type Fact } from "./dom";
import { Fresh, ageText, duration } from "./freshness";
import type { GatewayStatus } from "./gateway_messages";
import { hex, isActive, nameOf, sessionPhaseNames } from "./names";
import { Roster } from "./roster";
import { buildShell } from "./shell";
import { StartForm } from "./start_form";
import { Trace } from "./trace";
import { Trials } from "./trials";

const REFRESH_MS = 250;
const ABORT_AGAIN_MS = 4000;
const pausedPhases: readonly SessionPhase[] = [SessionPhase.SESSION_PAUSING, SessionPhase.SESSION_PAUSED];
const resumablePhases: readonly SessionPhase[] = [...pausedPhases, SessionPhase.SESSION_WAITING];

const connection = new Connection();
const { main, say } = buildShell(connection, "/");
const roster = new Roster(connection);
const trials = new Trials();
const trace = new Trace();

const session = new Fresh<SessionState>();
const plans = new Map<string, SessionPlan>();
const rig = new Fresh<RigState>();
const samples = new Fresh<SampleBlock>();
const gateway = new Fresh<GatewayStatus>();
let sessionWritten = 0n;

const phase = el("span", { class: "phase", id: "phase" }, "no session");
const counts = el("dl", { class: "facts" });
const progress = el("progress", { id: "progress", max: 1, value: 0, "aria-label": "Trials counted" });
const button = (id: string, text: string, key: string): HTMLButtonElement =>
  el("button", { id, type: "button", title: `${text} (Alt+${key})`, "aria-keyshortcuts": `Alt+${key}` }, text);
const pause = button("pause", "Pause", "P");
const resume = button("resume", "Resume", "R");
const abort = button("abort", "Abort", "A");
const clearFault = button("clear-fault", "Clear fault", "F");
const buttons = el("div", { class: "row" }, pause, resume, abort, clearFault);
const sessionPanel = panel("Session", "session", phase, progress, counts, buttons);
const startForm = new StartForm({ ask, say });
const tracePanel = panel("Hand and force", "trace-panel", trace.root);

main.append(
  el(
    "div",
    { class: "operator" },
    el("div", {}, sessionPanel.root, startForm.root, trials.current.root, roster.root),
    el("div", {}, tracePanel.root, trials.verdicts.root),
  ),
);

// Requests

async function ask(name: string, fields: Record<string, unknown> = {}): Promise<void> {
  if (connection.state !== "connected") return say(`${name} was NOT sent: disconnected.`, true);
  say(`${name}: sent, waiting for the reply…`);
  const reply = await connection.request(name, fields);
  say(`${name}: ${reply.is_done ? "done" : "refused"}. ${reply.message}`, !reply.is_done);
}

pause.addEventListener("click", () => void ask("pause"));
resume.addEventListener("click", () => void ask("resume"));
clearFault.addEventListener("click", () => void ask("clear_fault", { hold_number: rig.value?.hold_number ?? 0 }));
let abortArmedAt = -Infinity;
abort.addEventListener("click", () => {
  if (performance.now() - abortArmedAt < ABORT_AGAIN_MS) {
    abortArmedAt = -Infinity;
    void ask("abort");
  } else {
    abortArmedAt = performance.now();
    say(`Abort ends this session for good. Press Abort again within ${ABORT_AGAIN_MS / 1000} s.`, true);
  }
});
document.addEventListener("keydown", (event) => {
  if (!event.altKey || event.ctrlKey) return;
  const target = { p: pause, r: resume, a: abort, f: clearFault }[event.key.toLowerCase()];
  if (!target) return;
  event.preventDefault();
  if (!target.disabled) target.click();
});

// Subscriptions

connection.subscribe<SessionState>("session/state", (arrival) => {
  // A late joiner also receives the last states of older sessions: show the newest.
  const isOther = session.value && hex(session.value.session_id) !== hex(arrival.value.session_id);
  if (isOther && arrival.writtenNs < sessionWritten) return;
  sessionWritten = arrival.writtenNs;
  session.set(arrival);
  trials.showSession(hex(arrival.value.session_id));
});
connection.subscribe<SessionPlan>("session/plan", ({ value }) => plans.set(hex(value.session_id), value));
connection.subscribe<TrialVerdict>("trial/verdict", ({ value }) => trials.verdict(value));
connection.subscribe<TrialOutcome>("trial/outcome", ({ value }) => {
  trials.outcome(value);
  if (session.value && hex(value.program.session_id) === hex(session.value.session_id)) trace.setTrial(value.program);
});
connection.subscribe<{ program: TrialProgram }>("trial/command", ({ value }) => {
  trials.command(value.program);
  trace.setTrial(value.program);
});
connection.subscribe<RigDescription>("rig/description", ({ value }) => {
  trace.setRig(value);
  trials.setRig(value);
});
connection.subscribe<RigState>("rig/state", (arrival) => rig.set(arrival));
connection.subscribe<GatewayStatus>("gateway/status", (arrival) => gateway.set(arrival));
connection.subscribe<SampleBlock>("rig/samples", (arrival) => {
  samples.set(arrival);
  trace.add(arrival.value);
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

function sessionFacts(state: SessionState): Fact[] {
  const plan = plans.get(hex(state.session_id));
  return [
    ["Trials", `${state.counted} of ${state.planned} counted, ${state.rejected} rejected`],
    ["Posture", state.posture || "–"],
    ["Remaining", isActive(state.phase) ? `about ${duration(state.remaining_s)}` : "–"],
    ["Subject", plan ? `${plan.subject}, protocol ${plan.protocol_name}` : "–"],
    ["Id", hex(state.session_id)],
    ...(state.waiting_for ? [["Waiting for", state.waiting_for, "warn"] as Fact] : []),
    ...(state.message ? [["Message", state.message] as Fact] : []),
  ];
}

function showSession(): void {
  const state = session.value;
  const isGoing = state !== undefined && isActive(state.phase);
  setText(phase, state ? nameOf(sessionPhaseNames, state.phase) : "no session");
  phase.className = `phase ${state?.phase === SessionPhase.SESSION_FAILED ? "bad" : state?.phase === SessionPhase.SESSION_WAITING ? "warn" : ""}`;
  progress.max = Math.max(1, state?.planned ?? 1);
  progress.value = state?.counted ?? 0;
  facts(counts, state ? sessionFacts(state) : []);
  const mayOperate = connection.state === "connected" && connection.role === "operate";
  startForm.show(isGoing, mayOperate, roster.missing());
  pause.disabled = !mayOperate || !isGoing || pausedPhases.includes(state.phase);
  resume.disabled = !mayOperate || !isGoing || !resumablePhases.includes(state.phase);
  abort.disabled = !mayOperate || !isGoing;
  clearFault.disabled = !mayOperate || rig.value?.mode !== RigMode.RIG_HELD;
  // Without a session there is no age, and a session that has ended publishes no more.
  if (state) showAge(sessionPanel.age, session.age, isGoing ? 10 : Infinity);
}

function showTrial(): void {
  const isInTrial = rig.value?.mode === RigMode.RIG_IN_TRIAL;
  const phaseNow = isInTrial ? samples.value?.samples.at(-1)?.phase : undefined;
  trials.renderCurrent(rig.value, session.value, phaseNow, gateway.value?.thinned ?? 0);
  showAge(trials.current.age, rig.age, 2);
  showAge(tracePanel.age, samples.age, isInTrial ? 1 : Infinity);
}

setInterval(() => {
  roster.render();
  showSession();
  showTrial();
  trials.renderVerdicts();
  trace.renderValues();
}, REFRESH_MS);
