// The states of the desk as messages of the bus, and what the pages say in each: `strip` on the pages of the operator,
// `subject` on the subject's.

const ROLES = { rig: 0, scheduler: 1, identification: 2, archive: 3 };
const FREE = 1, ARMED = 2, IN_TRIAL = 3, HELD = 4;
const PHASE = { preparing: 0, ready: 1, running: 2, pausing: 3, paused: 4, waiting: 5, completing: 6, completed: 7, aborted: 8, failed: 9 };

const id = (n) => Uint8Array.from({ length: 16 }, () => n);
const SESSION = id(0x5a);
const RIG = id(0x11);

const session = (phase, more = {}) => ({
  session_id: SESSION, phase: PHASE[phase], posture: "distal", attempts: 7, counted: 5, rejected: 1, planned: 40, remaining_s: 118, ...more,
});
const rig = (mode, more = {}) => ({ rig_id: RIG, epoch: 1n, mode, next_sequence: 1000n, received_through: 990n, ...more });

const states = [
  { name: "nothing-there", present: [], strip: /^NOT READY rig is missing; scheduler is missing; identification is missing; archive is missing$/, subject: "Please wait for the operator." },
  { name: "ready", rig: rig(FREE), strip: /^READY no session runs; choose a subject and a protocol, then Start$/, subject: "Please wait for the operator." },
  { name: "preparing", rig: rig(FREE), session: session("preparing", { waiting_for: "rig: to be armed", counted: 0 }), strip: /^PREPARING for rig: to be armed$/, subject: "The experiment is being prepared. Please wait." },
  {
    name: "posture", rig: rig(ARMED),
    session: session("waiting", { waiting_for: "operator: bring the subject's hand to posture 'distal', (0.000, 0.520) m from the shoulder, and resume" }),
    strip: /^YOUR TURN bring the hand to distal \(0\.000, 0\.520 m from the shoulder\), then Resume$/, subject: "Bring your hand to the circle.",
  },
  { name: "running", rig: rig(IN_TRIAL), session: session("running"), strip: /^RUNNING trial 6 of 40 distal, about 2 min$/, subject: "The experiment is running." },
  { name: "pausing", rig: rig(IN_TRIAL), session: session("pausing"), strip: /^PAUSING after this trial$/, subject: "The experiment is running." },
  { name: "paused", rig: rig(ARMED), session: session("paused", { waiting_for: "operator: resume" }), strip: /^YOUR TURN the session is paused after 5 of 40 trials\. Resume when the subject is ready\.$/, subject: "Pause. You can rest." },
  { name: "waiting", rig: rig(ARMED), session: session("waiting", { waiting_for: "identification: set one's stiffness at 'distal'" }), sessionAgeMs: 57000, strip: /^WAITING for identification: set one's stiffness at 'distal'$/, subject: "Please wait for the operator." },
  {
    name: "limit", rig: rig(ARMED),
    session: session("waiting", { waiting_for: "operator: 8 trials rejected in set 1 at 'distal', the limit is 8 (last: off target); resume goes on" }),
    strip: /^YOUR TURN 8 trials rejected in set 1 at 'distal', the limit is 8 \(last: off target\); resume goes on$/, subject: "Please wait for the operator.",
  },
  {
    name: "stopped", rig: rig(HELD, { hold_number: 3, held_because: "stop by Anna, dashboard 127.0.0.1:5000 on results at 11:19:32 UTC; fault: emergency stop", fault_bits: 1, fault: "emergency stop" }),
    session: session("waiting", { waiting_for: "operator: the rig is held (stop by Anna); when it is safe, clear it, then resume" }),
    strip: /^EMERGENCY STOP pressed 11:19:32 UTC on results by Anna, dashboard 127\.0\.0\.1:5000; the rig is released\. When it is safe: Clear fault, then Resume\.$/,
    subject: "Let go. The experiment has stopped.",
  },
  {
    name: "held", rig: rig(HELD, { hold_number: 4, held_because: "fault: force limit", fault_bits: 2, fault: "force limit" }),
    session: session("waiting", { waiting_for: "operator: the rig is held (fault: force limit); when it is safe, clear it, then resume" }),
    strip: /^RIG HELD fault: force limit\. When it is safe: Clear fault, then Resume\.$/, subject: "Let go. The experiment has stopped.",
  },
  { name: "cleared", rig: rig(FREE), session: session("waiting", { waiting_for: "operator: the rig is not armed; resume" }), strip: /^YOUR TURN the rig is not armed; resume$/, subject: "Please wait for the operator." },
  { name: "rig-gone", rig: rig(IN_TRIAL), rigAgeMs: 5000, present: ["scheduler", "identification", "archive"], session: session("running"), strip: /^RIG GONE for ([5-9]|1\d) s The rig agent does not report\. What the rig does is not known; use the button at the rig\.$/, subject: "Let go. The experiment has stopped." },
  { name: "scheduler-gone", rig: rig(IN_TRIAL), present: ["rig", "identification", "archive"], stale: ["scheduler"], session: session("running"), strip: /^SCHEDULER GONE for \d+ s No new trial begins, and the rig is held soon\. The session resumes when the scheduler is back\.$/, subject: "Let go. The experiment has stopped." },
  { name: "completing", rig: rig(ARMED), session: session("completing", { counted: 40, waiting_for: "archive: receipts of 2 rejected trials" }), strip: /^COMPLETING every trial is done; archive: receipts of 2 rejected trials$/, subject: "The experiment is over. Thank you." },
  { name: "completed", rig: rig(FREE), session: session("completed", { counted: 40, rejected: 2, message: "40 trials counted" }), strip: /^COMPLETED sub-07, 40 trials counted, 2 rejected\. Results and archive have them\.$/, subject: "The experiment is over. Thank you." },
  { name: "aborted", rig: rig(FREE), session: session("aborted", { message: "aborted by request" }), strip: /^ABORTED after 5 of 40 trials: aborted by request$/, subject: "Please wait for the operator." },
  { name: "failed", rig: rig(FREE), session: session("failed", { message: "posture 'distal': out of the rig's reach" }), strip: /^FAILED posture 'distal': out of the rig's reach$/, subject: "Please wait for the operator." },
  { name: "disconnected", isDown: true, rig: rig(FREE), session: session("running"), strip: /^DISCONNECTED for \d+ s .*Values below are old\. To stop, use the button at the rig\. Reconnecting…$/, subject: "Let go. The connection is lost. Please wait." },
  { name: "back", rig: rig(FREE), session: session("running"), strip: /^RUNNING trial 6 of 40 distal, about 2 min$/, subject: "The experiment is running." },
];

const description = {
  rig_id: RIG, name: "simulated arm", driver: "simulated", kind: 0, link_lengths_m: [0.42, 0.48], encoder_counts_per_unit: [10000, 10000],
  encoder_sign: [1, 1], force_calibration_N_per_V: [10, 0, 0, 10], home_m: [0, 0.45], loop_rate_Hz: 1000, sample_rate_Hz: 1000,
  displacement_unit: "m", force_unit: "N", moves_nothing_real: true,
};
const plan = {
  session_id: SESSION, rig_id: RIG, subject: "sub-07", protocol_name: "unloaded", seed: 4711n, planned_trials: 40, started_at: "2026-03-02T11:00:00Z",
  software_version: "0.9.0", operator_name: "Anna", study: "cohort", is_pilot: true, postures: [{ name: "reference", position_m: [0, 0.38], trials: 8 }, { name: "distal", position_m: [0, 0.52], trials: 8 }, { name: "left", position_m: [-0.2, 0.4], trials: 8 }],
};

/// Estimates of a session that goes on: one posture well known, one with a wide interval, one undetermined.
const matrix = (value, error) => {
  const [a, b, c, d] = value;
  const root = Math.hypot(a - d, b + c);
  const [l2, l1] = [(a + d + root) / 2, (a + d - root) / 2];
  return {
    value, standard_error: value.map(() => error), low95: value.map((v) => v - 1.97 * error), high95: value.map((v) => v + 1.97 * error),
    has_ellipse: l1 > 0, size: Math.PI * l1 * l2, shape: l2 / l1, orientation_deg: (Math.atan2(b + c, a - d) * 90) / Math.PI, curl: Math.abs(b - c) / 2 / Math.sqrt(l1 * l2),
    covariance: Array(16).fill(NaN), known_bias: Array(4).fill(NaN), size_low95: 0.9 * Math.PI * l1 * l2, size_high95: 1.1 * Math.PI * l1 * l2, shape_low95: 0.95 * l2 / l1, shape_high95: 1.05 * l2 / l1,
    orientation_low95_deg: NaN, orientation_high95_deg: NaN, curl_low95: 0, curl_high95: 0.1,
  };
};
const estimate = (number, posture, index, at, more = {}) => ({
  estimate_id: id(number), session_id: SESSION, rig_id: RIG, posture, posture_index: index, posture_m: at, method: "state_variable", model: "linear", axes: 2,
  displacement_unit: "m", force_unit: "N", status: 0, trials_used: 8, samples: 12000n, mass_kg: matrix([1.6, -0.3, -0.28, 1.1], 0.02),
  damping_Ns_per_m: matrix([14, 3, 2.6, 9], 0.3), stiffness_N_per_m: matrix([220, 60, 48, 140], 4),
  spring_centre_m: { value: [0.0004, -0.0002], standard_error: [0.0001, 0.0001], low95: [0.0002, -0.0004], high95: [0.0006, 0] }, sigma_N: [0.12, 0.14], ...more,
});
const estimates = [
  estimate(1, "reference", 0, [0, 0.38]),
  estimate(2, "distal", 1, [0, 0.52], { trials_used: 4, trials_rejected: 1, status: 2, reasons: ["the intervals are wide"], stiffness_N_per_m: matrix([150, 20, 32, 260], 90) }),
  estimate(3, "left", 2, [-0.2, 0.4], { trials_used: 2, status: 1, reasons: ["2 of 3 directions"], mass_kg: {}, damping_Ns_per_m: {}, stiffness_N_per_m: {} }),
  estimate(4, "reference", 0, [0, 0.38], { method: "regression", stiffness_N_per_m: matrix([214, 58, 50, 143], 6) }),
];
const verdicts = [
  { trial_id: id(0x31), session_id: SESSION, attempt: 1, posture_index: 0, is_valid: true, detail: "valid: within every limit" },
  { trial_id: id(0x32), session_id: SESSION, attempt: 2, posture_index: 0, is_valid: false, reasons: [1, 4], detail: "off target: 6.1 mm, at most 5 mm; early reaction" },
];

/// Puts the gateway in a state and keeps it there until the next.
class Desk {
  #gateway;
  #timer;
  constructor(gateway) {
    this.#gateway = gateway;
  }

  enter(state) {
    clearInterval(this.#timer);
    const gateway = this.#gateway;
    gateway.isDown = state.isDown ?? false;
    if (gateway.isDown) return gateway.drop("the gateway ends");
    gateway.forget("service/health", "scheduler");
    const report = () => {
      for (const name of state.present ?? Object.keys(ROLES)) this.#health(name, true);
    };
    for (const name of state.stale ?? []) this.#health(name, true, 3000);
    for (const name of Object.keys(ROLES))
      if (!(state.present ?? Object.keys(ROLES)).includes(name) && !(state.stale ?? []).includes(name)) this.#health(name, false);
    report();
    this.#timer = setInterval(() => {
      report();
      if (state.rig && !state.rigAgeMs) gateway.say("rig/state", state.rig);
    }, 400);
    if (state.rig) {
      gateway.say("rig/description", description);
      gateway.say("rig/state", state.rig, { ageMs: state.rigAgeMs ?? 0 });
    }
    if (state.rigAgeMs) this.#health("rig", true, state.rigAgeMs);
    if (!state.session) return;
    gateway.say("session/plan", plan);
    if (state.session.counted > 0) {
      for (const [i, one] of estimates.entries()) gateway.say("estimate/condition", one, { key: String(i) });
      for (const [i, one] of verdicts.entries()) gateway.say("trial/verdict", one, { key: String(i) });
    }
    gateway.say("session/state", state.session, { ageMs: 0 });
    gateway.say("session/cue", { session_id: SESSION, target_m: [0, 0.52], target_diameter_m: 0.01, instruction: "Hold the handle on the circle.", shows_cursor: true });
  }

  #health(name, isThere, ageMs = 0) {
    const health = { instance_id: id(0xa0 + ROLES[name]), role: ROLES[name], name, host: "here", is_ready: true, state: "ready", software_version: "0.9.0", process_id: 42n, is_leaving: !isThere };
    this.#gateway.say("service/health", health, { key: name, ageMs });
  }

  end() {
    clearInterval(this.#timer);
  }
}

/// What the archive gives out of the same session.
function archive(gateway) {
  const base = `/api/sessions/${Buffer.from(SESSION).toString("hex")}`;
  const entry = { session_id: "5a".repeat(16), subject: "sub-07", protocol: "unloaded", seed: 4711, planned_trials: 24, started_at: "2026-03-02T11:00:00Z", software_version: "0.9.0", study: "", is_pilot: false, state: "completed" };
  const other = { ...entry, session_id: "5b".repeat(16), subject: "sub-08", started_at: "2026-03-03T09:30:00Z" };
  const earlier = { ...entry, session_id: "5c".repeat(16), started_at: "2026-02-23T10:15:00Z" };
  const certificate = { expected: 3000, received: 3000, resent: 0, duplicated: 0, missing: 0 };
  const framed = (topic, values) => Buffer.concat(values.flatMap((value) => {
    const data = gateway.encode(topic, value);
    const size = Buffer.alloc(4);
    size.writeUInt32LE(data.length);
    return [size, data];
  }));
  // A rise of 5 mm in 0.2 s after the onset, held by 1 N.
  const times_s = Array.from({ length: 141 }, (_, i) => (i - 20) / 100);
  const rise = (to) => times_s.map((time) => to * Math.min(1, Math.max(0, time / 0.2)));
  const course = (attempt, missing, size) => ({ attempt, posture: "reference", missing, times_s, displacement: [rise(0.005 * size), rise(0)], force: [rise(size), rise(-0.2 * size)] });
  const courses = { displacement_unit: "m", force_unit: "N", courses: [course(2, 12, 1), course(1, 0, 0.8)] };
  const stiffness = (session, value, error) => estimates.map((one) => ({ ...one, session_id: id(session), stiffness_N_per_m: one.status === 1 ? {} : matrix(value, error) }));
  gateway.answers.set("/api/sessions", [other, entry, earlier]);
  for (const [path, shown, moved] of [
    [base, entry, estimates],
    [base.replaceAll("5a", "5b"), other, stiffness(0x5b, [260, 40, 44, 120], 5)],
    [base.replaceAll("5a", "5c"), earlier, stiffness(0x5c, [180, 60, 48, 140], 2)],
  ]) {
    gateway.answers.set(path, { ...shown, certificate, trials: verdicts.map(({ attempt, trial_id }) => ({ trial_id: Buffer.from(trial_id).toString("hex"), attempt, posture: "reference", set: 1, end: 0, is_certified: true, first_sequence: 1, last_sequence: 1500, certificate })) });
    gateway.answers.set(`${path}/courses/2`, courses);
    gateway.answers.set(`${path}/messages?topic=trial/verdict`, framed("trial/verdict", verdicts));
    gateway.answers.set(`${path}/messages?topic=trial/outcome`, framed("trial/outcome", verdicts.map(({ trial_id, attempt }) => ({ trial_id, program: { session_id: moved[0].session_id, attempt, posture: "reference", set_number: 1 } }))));
    gateway.answers.set(`${path}/messages?topic=trial/review`, framed("trial/review", [{ trial_id: id(0x31), session_id: SESSION, attempt: 1, is_rejected: true, reason: "coughed", reviewed_by: "Anna", reviewed_ns: 1n }]));
    gateway.answers.set(`${path}/messages?topic=session/note`, framed("session/note", [{ note_id: id(0x41), session_id: SESSION, trial_id: id(0x31), kind: "note", text: "light on", written_by: "Anna", written_ns: 1772450372000000000n }]));
    gateway.answers.set(`${path}/messages?topic=estimate/history`, framed("estimate/condition", moved));
    gateway.answers.set(`${path}/messages?topic=session/plan`, framed("session/plan", [{ ...plan, session_id: moved[0].session_id, subject: shown.subject }]));
    gateway.answers.set(`${path}/messages?topic=session/state`, framed("session/state", [session("completed", { counted: 23, rejected: 1, planned: 24, session_id: moved[0].session_id })]));
  }
}

module.exports = { states, Desk, archive, SESSION, RIG, id, plan, description };
