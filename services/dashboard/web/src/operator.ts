// The operator's page: who is there, what goes on, and the means to steer it.

import { getJson } from "./access";
import { Connection, randomId } from "./connection";
import {
  endNames,
  hex,
  isActive,
  modeNames,
  phaseNames,
  reasonNames,
  type GatewayStatus,
  type RigDescription,
  type RigState,
  type SampleBlock,
  type SessionPlan,
  type SessionState,
  type TrialOutcome,
  type TrialProgram,
  type TrialVerdict,
} from "./contract";
import { el, panel, setText } from "./dom";
import { Fresh, ageText, duration } from "./freshness";
import { Roster } from "./roster";
import { buildShell } from "./shell";
import { Trace } from "./trace";

const REFRESH_MS = 250;

const connection = new Connection();
const { main, say } = buildShell(connection, "/");
const roster = new Roster(connection);
const trace = new Trace();

const session = new Fresh<SessionState>();
const plan = new Fresh<SessionPlan>();
const rig = new Fresh<RigState>();
const samples = new Fresh<SampleBlock>();
const gateway = new Fresh<GatewayStatus>();
let trial: TrialProgram | undefined;
const verdicts = new Map<number, TrialVerdict>();
const outcomes = new Map<number, TrialOutcome>();
let shownSession = "";
let sessionWritten = 0n;
let verdictsChanged = true;
const heldVerdicts = new Map<string, TrialVerdict>();

// Session

const phase = el("span", { class: "phase", id: "phase" }, "no session");
const counts = el("dl", { class: "facts" });
const progress = el("progress", { id: "progress", max: 1, value: 0, "aria-label": "Trials counted" });
const button = (id: string, text: string, key: string): HTMLButtonElement =>
  el("button", { id, type: "button", title: `${text} (Alt+${key})`, "aria-keyshortcuts": `Alt+${key}` }, text);
const pause = button("pause", "Pause", "P");
const resume = button("resume", "Resume", "R");
const abort = button("abort", "Abort", "A");
const clearFault = button("clear-fault", "Clear fault", "F");
const sessionPanel = panel(
  "Session",
  "session",
  phase,
  progress,
  counts,
  el("div", { class: "row" }, pause, resume, abort, clearFault),
);

const protocol = el("select", { id: "protocol" });
const subject = el("input", { id: "subject", value: "sub-01", required: true, size: 10, maxlength: 128 });
const seed = el("input", { id: "seed", type: "number", min: 0, step: 1, value: 1, required: true, class: "short" });
const start = el("button", { id: "start", type: "submit", class: "main" }, "Start");
const file = el("input", { id: "protocol-file", type: "file", accept: ".toml" });
const startForm = el(
  "form",
  { class: "row", id: "start-form" },
  el("label", {}, "Protocol", protocol),
  el("label", {}, "or a file", file),
  el("label", {}, "Subject", subject),
  el("label", {}, "Seed", seed),
  start,
);
const startPanel = panel("Start a session", "start-panel", startForm);
const protocols = new Map<string, string>();

async function loadProtocols(): Promise<void> {
  try {
    const list = await getJson<{ name: string; text: string }[]>("/api/protocols");
    const chosen = protocol.value;
    protocols.clear();
    for (const { name, text } of list) protocols.set(name, text);
    protocol.replaceChildren(...list.map(({ name }) => el("option", { value: name }, name)));
    if (protocols.has(chosen)) protocol.value = chosen;
  } catch (error) {
    say(`The protocols cannot be read: ${(error as Error).message}`, true);
  }
}

startForm.addEventListener("submit", (event) => {
  event.preventDefault();
  void (async () => {
    const chosen = file.files?.[0];
    const text = chosen ? await chosen.text() : protocols.get(protocol.value);
    if (!text) return say("A protocol is needed.", true);
    await ask("start", {
      session_id: randomId(),
      protocol_toml: text,
      subject: subject.value,
      seed: Number(seed.value),
    });
  })();
});

async function ask(name: string, fields: Record<string, unknown> = {}): Promise<void> {
  if (connection.state !== "connected") return say(`${name} was NOT sent: disconnected.`, true);
  say(`${name}: asked, waiting for the answer…`);
  const reply = await connection.request(name, fields);
  say(`${name}: ${reply.is_done ? "done" : "refused"}. ${reply.message}`, !reply.is_done);
}

pause.addEventListener("click", () => void ask("pause"));
resume.addEventListener("click", () => void ask("resume"));
clearFault.addEventListener("click", () => void ask("clear_fault"));
let abortArmedAt = -Infinity;
abort.addEventListener("click", () => {
  if (performance.now() - abortArmedAt < 4000) {
    abortArmedAt = -Infinity;
    void ask("abort");
  } else {
    abortArmedAt = performance.now();
    say("Abort ends this session for good. Press Abort once more within 4 s.", true);
  }
});
document.addEventListener("keydown", (event) => {
  if (!event.altKey || event.ctrlKey) return;
  const target = { p: pause, r: resume, a: abort, f: clearFault }[event.key.toLowerCase()];
  if (!target) return;
  event.preventDefault();
  if (!target.disabled) target.click();
});

// Trials

const trialFacts = el("dl", { class: "facts" });
const trialPanel = panel("Current trial", "trial", trialFacts);
const verdictBody = el("tbody", { id: "verdicts" });
const verdictHead = el(
  "tr",
  {},
  ...["Trial", "Posture", "Verdict", "Reason"].map((name) => el("th", { scope: "col" }, name)),
);
const verdictPanel = panel(
  "Verdicts",
  "verdict-panel",
  el("div", { class: "scroll", tabindex: 0 }, el("table", {}, el("thead", {}, verdictHead), verdictBody)),
);
const tracePanel = panel("Hand and force", "trace-panel", trace.root);

main.append(
  el(
    "div",
    { class: "operator" },
    el("div", {}, sessionPanel.root, startPanel.root, trialPanel.root, roster.root),
    el("div", {}, tracePanel.root, verdictPanel.root),
  ),
);

// What comes

connection.subscribe<SessionState>("session/state", (arrival) => {
  // Old sessions' last states come too, to who comes late: the newest one is meant.
  const isOther = session.value && hex(session.value.session_id) !== hex(arrival.value.session_id);
  if (isOther && arrival.writtenNs < sessionWritten) return;
  sessionWritten = arrival.writtenNs;
  session.set(arrival);
  const id = hex(arrival.value.session_id);
  if (id === shownSession) return;
  shownSession = id;
  verdicts.clear();
  outcomes.clear();
  verdictsChanged = true;
  for (const old of heldVerdicts.values()) keepVerdict(old);
});
function keepVerdict(verdict: TrialVerdict): void {
  if (hex(verdict.session_id) !== shownSession) return;
  verdicts.set(verdict.attempt, verdict);
  verdictsChanged = true;
}

connection.subscribe<SessionPlan>("session/plan", (arrival) => plan.set(arrival));
connection.subscribe<TrialVerdict>("trial/verdict", ({ value }) => {
  heldVerdicts.set(hex(value.trial_id), value);
  keepVerdict(value);
});
connection.subscribe<TrialOutcome>("trial/outcome", ({ value }) => {
  outcomes.set(value.program.attempt, value);
  trace.setTrial(value.program);
  if (!trial || value.program.attempt >= trial.attempt) trial = value.program;
});
connection.subscribe<{ program: TrialProgram }>("trial/command", ({ value }) => {
  trial = value.program;
  trace.setTrial(value.program);
});
connection.subscribe<RigDescription>("rig/description", ({ value }) => trace.setRig(value));
connection.subscribe<RigState>("rig/state", (arrival) => rig.set(arrival));
connection.subscribe<GatewayStatus>("gateway/status", (arrival) => gateway.set(arrival));
connection.subscribe<SampleBlock>("rig/samples", (arrival) => {
  samples.set(arrival);
  trace.add(arrival.value);
});
connection.onState((state) => {
  if (state === "connected") void loadProtocols();
});
document.addEventListener("tonus-token", () => void loadProtocols());

// What is shown

function facts(list: HTMLElement, entries: [string, string, string?][]): void {
  const wanted = entries.flatMap(([name, text, tone]) => [
    el("dt", {}, name),
    el("dd", { class: tone, id: `fact-${name.toLowerCase().replaceAll(" ", "-")}` }, text),
  ]);
  const isSame =
    wanted.length === list.children.length &&
    wanted.every((item, i) => item.textContent === list.children[i]!.textContent && item.className === list.children[i]!.className);
  if (!isSame) list.replaceChildren(...wanted);
}

function showAge(element: HTMLElement, age: number | undefined, limit: number): void {
  setText(element, ageText(age));
  element.className = age === undefined || age > limit ? "age old" : "age";
}

function showSession(): void {
  const state = session.value;
  const isGoing = state !== undefined && isActive(state.phase);
  setText(phase, state ? (phaseNames[state.phase] ?? "?") : "no session");
  phase.className = `phase ${state?.phase === 9 ? "bad" : state?.phase === 5 ? "warn" : ""}`;
  progress.max = Math.max(1, state?.planned ?? 1);
  progress.value = state?.counted ?? 0;
  facts(counts, [
    ...(state
      ? ([
          ["Trials", `${state.counted} of ${state.planned} counted, ${state.rejected} rejected`],
          ["Posture", state.posture || "–"],
          ["Remaining", isGoing ? `about ${duration(state.remaining_s)}` : "–"],
          ["Subject", plan.value ? `${plan.value.subject}, protocol ${plan.value.protocol_name}` : "–"],
          ["Id", hex(state.session_id)],
        ] as [string, string][])
      : []),
    ...(state?.waiting_for ? [["Waiting for", state.waiting_for, "warn"] as [string, string, string]] : []),
    ...(state?.message ? [["Message", state.message] as [string, string]] : []),
  ]);
  const mayOperate = connection.state === "connected" && connection.role === "operate";
  const missing = roster.missing();
  start.disabled = !mayOperate || isGoing || missing !== "";
  setText(startPanel.age, isGoing ? "a session goes on" : missing);
  startPanel.age.className = missing && !isGoing ? "age old" : "age";
  pause.disabled = !mayOperate || !isGoing || state.phase === 3 || state.phase === 4;
  resume.disabled = !mayOperate || !isGoing || ![3, 4, 5].includes(state.phase);
  abort.disabled = !mayOperate || !isGoing;
  clearFault.disabled = !mayOperate || rig.value?.mode !== 3;
  // A session that is over says nothing more: its state does not grow old.
  showAge(sessionPanel.age, session.age, isGoing ? 10 : Infinity);
}

function showTrial(): void {
  const state = rig.value;
  const entries: [string, string, string?][] = [];
  if (trial) entries.push(["Attempt", String(trial.attempt)], ["At", trial.posture]);
  if (state) {
    entries.push(
      ["Rig", modeNames[state.mode] ?? "?", state.mode === 3 ? "bad" : undefined],
      ["Samples", `${state.next_sequence}, of which archived ${state.received_through}`],
      ["Overruns", String(state.overruns), state.overruns > 0n ? "warn" : undefined],
    );
    if (state.fault) entries.push(["Fault", state.fault, "bad"]);
  }
  const mine = gateway.value?.thinned;
  if (mine) entries.push(["Thinned", `${mine} live messages left out for slow pages`, "warn"]);
  facts(trialFacts, entries);
  showAge(trialPanel.age, rig.age, 2);
}

function showVerdicts(): void {
  setText(verdictPanel.age, verdicts.size > 0 ? `${verdicts.size} judged` : "none yet");
  if (!verdictsChanged) return;
  verdictsChanged = false;
  const newestFirst = [...verdicts.values()].sort((a, b) => b.attempt - a.attempt);
  verdictBody.replaceChildren(
    ...newestFirst.map((verdict) => {
      const outcome = outcomes.get(verdict.attempt);
      const reasons = Array.from(verdict.reasons, (reason) => reasonNames[reason] ?? "?").join(", ");
      const end = outcome && outcome.end !== 0 ? ` (${endNames[outcome.end]})` : "";
      return el(
        "tr",
        {},
        el("td", {}, String(verdict.attempt)),
        el("td", {}, outcome?.program.posture ?? ""),
        el("td", { class: verdict.is_valid ? "good" : "bad" }, verdict.is_valid ? "valid" : "rejected"),
        el("td", {}, verdict.is_valid ? verdict.detail : `${reasons}${end}: ${verdict.detail}`),
      );
    }),
  );
}

setInterval(() => {
  roster.render();
  showSession();
  showTrial();
  showVerdicts();
  const isTrial = rig.value?.mode === 2;
  showAge(tracePanel.age, samples.age, isTrial ? 1 : Infinity);
}, REFRESH_MS);
