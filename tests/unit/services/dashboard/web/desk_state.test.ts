import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { RigMode, SessionPhase, type RigState, type SessionState } from "../../../../../services/dashboard/web/src/contract";
import { reasonsAgainst, stopOf, stripOf, type DeskView } from "../../../../../services/dashboard/web/src/desk_state";
import { cleanName } from "../../../../../services/dashboard/web/src/operator_name";
import { subjectProblem, subjectText } from "../../../../../services/dashboard/web/src/start_rules";
import { english, subjectLineOf, textsProblem } from "../../../../../services/dashboard/web/src/subject_lines";

const session = (phase: SessionPhase, more: Partial<SessionState> = {}): SessionState => ({
  session_id: new Uint8Array(16), phase, waiting_for: "", message: "", posture: "distal", trial_id: new Uint8Array(16),
  attempts: 7, counted: 5, rejected: 1, planned: 40, remaining_s: 118, experiment_s: 0, conditions: [], ...more,
});

const rig = (mode: RigMode, heldBecause = ""): RigState => ({
  rig_id: new Uint8Array(16), epoch: 1n, mode, trial_id: new Uint8Array(16), session_id: new Uint8Array(16), hold_number: 1,
  held_because: heldBecause, next_sequence: 0n, received_through: 0n, spool_bytes: 0n, fault_bits: 0, fault: "", overruns: 0n,
  dropped_samples: 0n, is_realtime_paced: true, rig_clock_ns: 0n,
});

const view = (more: Partial<DeskView> = {}): DeskView => ({
  link: "connected", linkReason: "", linkLostFor: 0, role: "operate", subject: "sub-01", missing: [], rigSilence: 0.1,
  schedulerSilence: 0.1, rig: rig(RigMode.RIG_ARMED), ...more,
});

test("a lost connection hides every state that is not known any more", () => {
  const strip = stripOf(view({ link: "disconnected", linkReason: "the gateway ends.", linkLostFor: 5.9, session: session(SessionPhase.SESSION_RUNNING) }));
  assert.equal(strip.key, "disconnected");
  assert.equal(strip.head, "DISCONNECTED for 5 s");
});

test("a rig that is silent is gone, whatever it said last, and a session that runs is not said to run", () => {
  const running = session(SessionPhase.SESSION_RUNNING);
  assert.equal(stripOf(view({ rigSilence: 2.0, session: running })).key, "running");
  assert.equal(stripOf(view({ rigSilence: 2.1, session: running })).key, "rig-gone");
  const held = stripOf(view({ rigSilence: 9, rig: rig(RigMode.RIG_HELD, "fault: force limit"), session: running }));
  assert.equal(held.head, "RIG GONE for 9 s");
  assert.match(held.text, /It was held: fault: force limit/);
});

test("a stop outranks what the session waits for, and tells who pressed it, where and when", () => {
  const strip = stripOf(view({ rig: rig(RigMode.RIG_HELD, "stop by dashboard 127.0.0.1:1 on subject at 11:19:32 UTC; fault: emergency stop"), session: session(SessionPhase.SESSION_WAITING) }));
  assert.equal(strip.head, "EMERGENCY STOP");
  assert.equal(strip.next, "clear-fault");
  assert.equal(strip.tone, "bad");
  assert.match(strip.text, /^pressed 11:19:32 UTC on subject by dashboard 127\.0\.0\.1:1; the rig is released/);
  assert.equal(stopOf("stop by tonus stop"), "pressed by tonus stop");
  assert.equal(stopOf("fault: emergency stop"), "at the rig");
  assert.equal(stopOf("fault: force limit"), undefined);
});

test("a fault that has been cleared is not stated any more", () => {
  const waiting = session(SessionPhase.SESSION_WAITING, { waiting_for: "operator: the rig is not armed; resume" });
  const strip = stripOf(view({ rig: { ...rig(RigMode.RIG_FREE), fault: "emergency stop" }, session: waiting }));
  assert.equal(strip.key, "your-turn");
  assert.doesNotMatch(strip.text, /emergency/);
});

test("a wait for a service is calm, and one for a person is that person's turn", () => {
  const of = (waiting_for: string) => stripOf(view({ session: session(SessionPhase.SESSION_WAITING, { waiting_for }) }));
  assert.equal(of("identification: set one's stiffness at 'distal'").tone, "wait");
  assert.equal(of("operator: 8 trials rejected; resume goes on").tone, "turn");
  assert.equal(of("operator: something else").text, "something else; then Resume");
});

test("the posture to be taken is told from the hand where the hand is known", () => {
  const waiting = session(SessionPhase.SESSION_WAITING, { waiting_for: "operator: bring the subject's hand to posture 'distal', (0.000, 0.520) m from the shoulder, and resume" });
  assert.equal(stripOf(view({ session: waiting })).text, "bring the hand to distal (0.000, 0.520 m from the shoulder), then Resume");
  const near = view({ session: waiting, handOffset: { distance_m: 0.0121, direction_deg: -320.2 } });
  assert.equal(stripOf(near).text, "bring the hand to distal (12 mm away, towards 40°), then Resume");
});

test("every control that cannot be pressed has its reason", () => {
  const ready = reasonsAgainst(view({ rig: rig(RigMode.RIG_FREE) }));
  assert.deepEqual(ready, { start: "", pause: "no session", resume: "no session", "abort-trial": "no trial runs", abort: "no session", "clear-fault": "no fault" });
  const held = reasonsAgainst(view({ rig: rig(RigMode.RIG_HELD), session: session(SessionPhase.SESSION_WAITING) }));
  assert.equal(held["clear-fault"], "");
  assert.equal(held.resume, "clear first");
  assert.equal(held.start, "a session runs");
  for (const reason of Object.values(reasonsAgainst(view({ role: "view" })))) assert.equal(reason, "viewer only");
  for (const reason of Object.values(reasonsAgainst(view({ link: "disconnected" })))) assert.equal(reason, "not connected");
});

test("the subject is told the same in every phase of a trial, and to let go after a stop", () => {
  const running = session(SessionPhase.SESSION_RUNNING);
  for (const mode of [RigMode.RIG_FREE, RigMode.RIG_ARMED, RigMode.RIG_IN_TRIAL]) assert.equal(subjectLineOf(view({ rig: rig(mode), session: running })), "running");
  assert.equal(subjectLineOf(view({ rig: rig(RigMode.RIG_IN_TRIAL), session: session(SessionPhase.SESSION_PAUSING) })), "running");
  assert.equal(subjectLineOf(view({ rig: rig(RigMode.RIG_HELD, "stop by x"), session: running })), "stopped");
  assert.equal(subjectLineOf(view({ rigSilence: 5, session: running })), "stopped");
});

test("each language has each of the subject's lines", () => {
  assert.equal(textsProblem(english), "");
  const folder = process.env["TONUS_LANGUAGES"]!;
  const files = readdirSync(folder);
  assert.ok(files.includes("de.json"));
  for (const file of files) assert.equal(textsProblem(JSON.parse(readFileSync(join(folder, file), "utf8"))), "", file);
  assert.match(textsProblem({ name: "x" }), /stopped.*missing/);
});

test("a subject's id is one that BIDS allows", () => {
  for (const id of ["sub-01", "01", "sub-Anna7"]) assert.equal(subjectProblem(id), "");
  for (const id of ["", " ", "sub-", "sub-01_b", "a b", "../x", "sub-é"]) assert.notEqual(subjectProblem(id), "", id);
  assert.equal(subjectText({ subject: "sub-2", sessions: 2, pilot_sessions: 1, subject_facts: {} }), "sub-2 (2 sessions, 1 pilot)");
  assert.equal(subjectText({ subject: "sub-10", sessions: 1, pilot_sessions: 0, subject_facts: {} }), "sub-10 (1 session)");
});

test("an operator's name cannot be read as another part of the record", () => {
  assert.equal(cleanName(" Anna;  B, on results "), "Anna B on results");
  assert.equal(cleanName("Jörg O'Neill"), "Jörg O'Neill");
});
