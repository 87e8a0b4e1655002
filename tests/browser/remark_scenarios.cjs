// What an operator says of trials and of a session: rejections, repeats, notes, markers; and the form that starts one.
// Each scenario gets the tools of states_in_browser.cjs.

const { join } = require("node:path");
const { SESSION, RIG, id, description } = require("./desk_states.cjs");

const hexOf = (bytes) => Buffer.from(bytes).toString("hex");
const program = (attempt) => ({ session_id: SESSION, rig_id: RIG, attempt, posture: "reference", posture_index: 0, posture_m: [0, 0.38], set_number: 1, amplitude_m: 0.005 });
const EPOCH = 1n;

/// Samples of one trial: at rest, then a push of 5 mm along the rig's first joint's motion.
function playTrial(gateway, trial, firstNs) {
  const samples = Array.from({ length: 200 }, (_, i) => {
    const isPush = i >= 100;
    const rise = isPush ? Math.min(1, (i - 100) / 40) : 0;
    return { acquisition_ns: firstNs + BigInt(i) * 4_000_000n, encoder_count: [100 * rise, 15708 + 50 * rise], force_V: [0.1 * rise, -0.02 * rise], phase: isPush ? 5 : 2 };
  });
  for (let at = 0; at < samples.length; at += 50)
    gateway.say("rig/samples", { rig_id: RIG, session_id: SESSION, trial_id: trial, epoch: EPOCH, first_sequence: BigInt(at), samples: samples.slice(at, at + 50) }, { isKept: false });
  return samples.at(-1).acquisition_ns;
}

/// Rejects the last trial for a reason, has another one repeated, notes something on it, and marks the session: what is sent,
/// and what is shown once the scheduler has said it.
async function remarks({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 1, 5]) {
    gateway.forgetAll();
    desk.enter(named("running"));
    const name = `remarks, ${looks[lookNumber].viewport.width}`;
    const page = await openPage(browser, gateway, "", looks[lookNumber]);
    await says(page, "", named("running"), name);
    gateway.requests.length = 0;
    gateway.reply = answerRemarks(gateway);
    let clock = 10_000_000_000n;
    for (const attempt of [1, 2]) {
      const trial = id(0x30 + attempt);
      gateway.say("trial/command", { trial_id: trial, program: program(attempt) }, { key: hexOf(trial) });
      clock = playTrial(gateway, trial, clock) + 4_000_000n;
      gateway.say("trial/outcome", { trial_id: trial, program: program(attempt), epoch: EPOCH }, { key: hexOf(trial) });
      gateway.say("trial/verdict", { trial_id: trial, session_id: SESSION, attempt, is_valid: true, detail: "valid: start 1.2 mm (limit 5.0), rest 3.0 mm/s (20.0) and 0.10 N (1.00), moved 6.1 mm (15.0), end 2.0 mm/s (25.0)" }, { key: String(attempt) });
    }
    const text = (selector) => page.locator(selector).allTextContents();
    await until(async () => { const seen = await text("#last-trial-age"); return [seen[0] === "trial 2: reference, valid", seen]; }, `${name}: the last trial is shown`);
    await until(async () => { const seen = await page.locator("#last-trial .allowed").count(); return [seen === 2, seen]; }, `${name}: excursion and force at rest have the bands that the verdict names`);
    await page.click("#reject-trial");
    await until(async () => { const seen = await page.textContent("#notice"); return [seen === "Reject: write the reason first.", seen]; }, `${name}: a rejection needs a reason`);
    await page.keyboard.type("coughed");
    await page.click("#reject-trial");
    await until(async () => { const seen = await text("#verdicts tr:first-child td"); return [seen.slice(2).join("; ") === "rejected by hand; coughed (Anna, dashboard)", seen]; }, `${name}: the rejection is shown with its reason`);
    await until(async () => { const seen = await text("#verdict-panel-age"); return [seen[0] === "2 judged, 1 rejected", seen]; }, `${name}: it counts as rejected`);
    await page.click("#reject-trial");
    await page.keyboard.type("again");
    await page.click("#reject-trial");
    await until(async () => { const seen = await page.textContent("#notice"); return [seen === "Rejection is not possible now: it is rejected already.", seen]; }, `${name}: not twice`);
    await page.fill("#trial-text", "");
    await page.locator("#verdicts tr:nth-child(2) button").click();
    await until(async () => { const seen = await text("#last-trial-age"); return [seen[0] === "trial 1: reference, valid", seen]; }, `${name}: any trial is shown`);
    await page.fill("#trial-text", "hand slipped");
    await page.click("#note-trial");
    await until(async () => { const seen = await text("#notes tr:first-child td"); return [seen[1] === "1" && seen[2] === "hand slipped", seen]; }, `${name}: a trial's note names it`);
    await page.click("#repeat-trial");
    await until(async () => { const seen = await text("#verdicts tr:nth-child(2) td"); return [seen.slice(2).join("; ") === "rejected by hand; repeat (Anna, dashboard)", seen]; }, `${name}: a repeat is a rejection that says so`);
    await page.keyboard.press("Alt+n");
    await page.keyboard.type("light on");
    await page.keyboard.press("Enter");
    await page.click('[data-marker="coughed"]');
    await until(async () => { const seen = await text("#notes td:nth-child(3)"); return [["light on", "▸ coughed", "hand slipped"].every((one) => seen.includes(one)), seen]; }, `${name}: notes and markers are listed`);
    await until(async () => { const seen = await page.locator(".trace").getAttribute("data-marks"); return [seen === "3", seen]; }, `${name}: they are flags on the traces`);
    const sent = gateway.requests.map(({ request, trial_id, text: said, note_kind }) => [request, trial_id, said, note_kind].filter(Boolean).join(" "));
    const wanted = [`reject_trial ${hexOf(id(0x32))} coughed`, `note ${hexOf(id(0x31))} hand slipped`, `reject_trial ${hexOf(id(0x31))} repeat`, "note light on note", "note coughed marker"];
    if (sent.join("\n") !== wanted.join("\n")) fail(`${name}: asked for ${wanted.join(" | ")}; seen: ${sent.join(" | ")}`);
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `operator-remarks-${looks[lookNumber].viewport.width}.png`) });
    await page.context().close();
  }
}

/// As a scheduler does: a rejection becomes a review, a note is stamped with the rig's clock.
function answerRemarks(gateway) {
  let written = 1_772_450_372_000_000_000n;
  return ({ request_id, request, trial_id, text, note_kind }) => {
    written += 1_000_000_000n;
    const trial = trial_id ? Buffer.from(trial_id, "hex") : undefined;
    if (request === "reject_trial")
      gateway.say("trial/review", { trial_id: trial, session_id: SESSION, is_rejected: true, reason: text, reviewed_by: "Anna, dashboard", reviewed_ns: written }, { key: trial_id });
    if (request === "note")
      gateway.say("session/note", { note_id: Buffer.from(request_id, "hex"), session_id: SESSION, trial_id: trial, kind: note_kind ?? "note", text, written_by: "Anna, dashboard", written_ns: written, has_rig_clock: true, rig_clock_ns: 11_000_000_000n + (written % 5_000_000_000n) / 10n, epoch: EPOCH }, { key: request_id });
    return { request_id, request, is_done: true, message: "done", requested_by: "Anna, dashboard" };
  };
}

const accepted = (trials) => ({ is_accepted: true, kind: "unloaded", name: "unloaded", problem: null, document: {}, preview: { trials, duration_s: 300, postures: [], extremes: [{ what: "force to expect", value: 12.14, low: null, high: 22.25, unit: "N" }] } });
const facts = { age_years: 31, sex: "female", handedness: "right", measured_arm: "right", height_m: null, weight_kg: null, link_lengths_m: [0.315, 0.34], circumferences_m: [null, null], shoulder_m: [null, null] };

/// A wrong file, then the list; a subject that the archive knows, as a pilot of a study: what is shown before, and what is sent.
async function startForm({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 5]) {
    gateway.forgetAll();
    desk.enter(named("ready"));
    const name = `start form, ${looks[lookNumber].viewport.width}`;
    gateway.answers.set("/api/protocols/check", (body) => (body.includes("kind") ? accepted(40) : { is_accepted: false, kind: "", name: "", problem: { key: "", line: 1, message: "not TOML: expected =" }, document: null, preview: null }));
    gateway.answers.set("/api/subjects", [{ subject: "sub-07", sessions: 2, pilot_sessions: 1, subject_facts: facts }]);
    gateway.reply = ({ request_id, request }) => ({ request_id, request, is_done: true, message: "started", requested_by: "test" });
    gateway.requests.length = 0;
    const page = await openPage(browser, gateway, "", looks[lookNumber]);
    await says(page, "", named("ready"), name);
    const preview = (wanted, what) => until(async () => { const seen = await page.textContent("#preview"); return [seen === wanted, seen]; }, `${name}: ${what}`);
    await preview("40 trials, about 5 min 00 s if none is repeated", "what the protocol would do is shown before");
    await page.setInputFiles("#protocol-file", { name: "wrong.toml", mimeType: "text/plain", buffer: Buffer.from("no protocol") });
    await preview("line 1: not TOML: expected =", "what is wrong with a file is shown before");
    await page.selectOption("#protocol", "unloaded");
    await preview("40 trials, about 5 min 00 s if none is repeated", "the list takes the file's place");
    await page.selectOption("#known-subject", "sub-07");
    await until(async () => { const seen = await page.inputValue("#upper-arm"); return [seen === "31.5", seen]; }, `${name}: what is known of a subject is recalled`);
    await page.click("#subject-details summary");
    await page.click("#extremes-details summary");
    await page.fill("#weight", "61.5");
    await page.selectOption("#study", "cohort");
    await page.check("#pilot");
    await page.fill("#seed", "11");
    const limits = await page.locator("#extremes li").allTextContents();
    if (limits.join() !== "force to expect: 12.1 N (allowed: at most 22.3 N)") fail(`${name}: extremes beside their limits; seen: ${limits}`);
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `operator-start-${looks[lookNumber].viewport.width}.png`) });
    await page.click("#start");
    await until(async () => [gateway.requests.some(({ request }) => request === "start"), "no start"], `${name}: it starts`);
    const { subject, seed, study, is_pilot, protocol_toml, subject_facts } = gateway.requests.find(({ request }) => request === "start") ?? {};
    const sent = JSON.stringify({ subject, seed, study, is_pilot, protocol_toml, subject_facts });
    const wanted = JSON.stringify({ subject: "sub-07", seed: 11, study: "cohort", is_pilot: true, protocol_toml: 'kind = "unloaded"', subject_facts: { ...facts, weight_kg: 61.5 } });
    if (sent !== wanted) fail(`${name}: asked for ${wanted}; seen: ${sent}`);
    await page.context().close();
  }
}

/// Channels beside force and motion are drawn where the rig has some, and nothing of them is asked for where it has none.
async function auxiliary({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 5]) {
    gateway.forgetAll();
    desk.enter(named("running"));
    const name = `auxiliary channels, ${looks[lookNumber].viewport.width}`;
    const page = await openPage(browser, gateway, "", looks[lookNumber]);
    await says(page, "", named("running"), name);
    if (await page.locator("#auxiliary").isVisible()) fail(`${name}: a rig without them shows none`);
    const channels = [{ name: "BICEPS", type: "EMG", unit: "mV", unit_per_value: 0.5, values_per_sample: 2 }, { name: "GRIP", type: "MISC", unit: "N", unit_per_value: 10, values_per_sample: 1 }];
    gateway.say("rig/description", { ...description, auxiliary_channels: channels });
    await page.locator("#auxiliary").waitFor({ timeout: 20000 });
    // 0.5 s at 1 kHz: BICEPS twice a sample, 0.2 and -0.6, GRIP once, 0.4; each times its unit.
    const block = (first) => ({ rig_id: RIG, epoch: EPOCH, first_sequence: BigInt(first), sample_count: 100, values: Array.from({ length: 300 }, (_, i) => [0.2, -0.6, 0.4][i % 3]) });
    for (let first = 0; first < 500; first += 100) gateway.say("rig/auxiliary", block(first), { isKept: false });
    await until(async () => { const seen = await page.locator("#auxiliary output").allTextContents(); return [seen.join() === "-0.300 mV,4.00 N", seen]; }, `${name}: values in their units`);
    const drawn = await page.locator('[data-channel="GRIP"] polyline').getAttribute("points");
    if (drawn.split(" ").length !== 30) fail(`${name}: 0.5 of 10 s fill 30 of 600 bins; seen: ${drawn.split(" ").length}`);
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `operator-auxiliary-${looks[lookNumber].viewport.width}.png`) });
    await page.context().close();
  }
}

module.exports = { scenarios: [remarks, startForm, auxiliary] };
