// The studies' page, the protocols' page, and exports from the archive's page. Each scenario gets the tools of
// states_in_browser.cjs.

const { join } = require("node:path");

const done = (protocol, session) => ({ protocol, file: protocol, session_id: session, started_at: "2026-03-02T11:00:00Z", state: "completed", counted: 40, planned: 40, is_pilot: false, is_done: true });
const due = (protocol) => ({ protocol, file: protocol, session_id: null, started_at: null, state: null, counted: 0, planned: 0, is_pilot: false, is_done: false });

/// Two subjects, one of whom has begun.
const study = (isOver) => ({
  study: "cohort", file: "cohort", problem: null,
  subjects: [
    { subject: "s01", seed: 1, done: isOver ? 2 : 1, due: isOver ? 0 : 1, sessions: [done("unloaded", "5a".repeat(16)), isOver ? done("loaded", "5c".repeat(16)) : due("loaded")], others: [{ ...done("unloaded", "5b".repeat(16)), is_pilot: true, is_done: false }] },
    { subject: "s02", seed: 2, done: isOver ? 1 : 0, due: isOver ? 0 : 1, sessions: [isOver ? done("unloaded", "5d".repeat(16)) : due("unloaded")], others: [] },
  ],
  next: isOver ? null : { subject: "s01", protocol: "loaded", file: "loaded", seed: 1 },
});

/// A study of two subjects: who is next, the session prepared with one click, and what is said once all is done.
async function studies({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 1, 5]) {
    gateway.forgetAll();
    desk.enter(named("ready"));
    const name = `studies, ${looks[lookNumber].viewport.width}`;
    gateway.answers.set("/api/studies", [study(false)]);
    gateway.answers.set("/api/protocols", [{ name: "unloaded", text: 'kind = "unloaded"' }, { name: "loaded", text: 'kind = "loaded"' }, { name: "cohort", text: 'kind = "study"\nname = "cohort"' }]);
    gateway.reply = ({ request_id, request }) => ({ request_id, request, is_done: true, message: "started", requested_by: "test" });
    const page = await openPage(browser, gateway, "studies", looks[lookNumber]);
    await says(page, "studies", named("ready"), name);
    await until(async () => { const seen = await page.textContent(".next"); return [seen === "Next: s01, loaded. Prepare this session", seen]; }, `${name}: says who is next`);
    const rows = await page.locator("#studies tbody tr").evaluateAll((all) => all.map((row) => Array.from(row.cells, (cell) => cell.innerText.replaceAll("\n", " | ")).join("; ")));
    const wanted = ["s01; unloaded: done | loaded: due; 1; 1; unloaded: completed, pilot", "s02; unloaded: due; 0; 1; "];
    if (rows.join("\n").trim() !== wanted.join("\n").trim()) fail(`${name}: sessions done and due; seen: ${rows.join(" || ")}`);
    const age = await page.textContent("#study-cohort-age");
    if (age !== "1 of 3 sessions done, 0 of 2 subjects") fail(`${name}: how far it is; seen: ${age}`);
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `studies-${looks[lookNumber].viewport.width}.png`) });
    await page.click(".next a");
    await until(async () => { const seen = await page.evaluate(() => ["#subject", "#study", "#protocol", "#seed"].map((id) => document.querySelector(id)?.value).join(" ")); return [seen === "s01 cohort loaded 1", seen]; }, `${name}: the form has what is due`);
    await page.locator("#start[aria-disabled=false]").click();
    gateway.requests.length = 0;
    await page.goto(`${gateway.url}/studies`);
    gateway.answers.set("/api/studies", [study(true)]);
    await page.click("#reload");
    await until(async () => { const seen = await page.textContent(".next"); return [seen === "Every session is done.", seen]; }, `${name}: says that all is done`);
    await page.context().close();
  }
}

const keys = {
  unloaded: [
    { name: "schema", expected: "a whole number, 1 to 1", preset: "", is_needed: true, unit: "" },
    { name: "kind", expected: "one of unloaded, loaded, replay", preset: "", is_needed: true, unit: "" },
    { name: "name", expected: "text of 1 to 80 characters", preset: "", is_needed: true, unit: "" },
    { name: "confirm_posture", expected: "true or false", preset: "false", is_needed: false, unit: "" },
    { name: "posture[].name", expected: "text of 1 to 40 characters", preset: "", is_needed: true, unit: "" },
    { name: "posture[].position_m", expected: "[x, y], each -1 to 1 m", preset: "", is_needed: true, unit: "m" },
    { name: "perturbation.amplitude_m", expected: "0.0005 to 0.03 m", preset: "", is_needed: true, unit: "m" },
    { name: "perturbation.hold_s", expected: "[low, high] with low <= high, or one number, 0.2 to 30 s", preset: "", is_needed: true, unit: "s" },
  ],
};
keys.loaded = [...keys.unloaded, { name: "bias.sets_along", expected: "a list, each one of none, +major, -major", preset: "", is_needed: true, unit: "" }];
keys.replay = [
  ...keys.unloaded.slice(0, 2),
  { name: "recording[].name", expected: "text of 1 to 40 characters", preset: "", is_needed: true, unit: "" },
  { name: "recording[].event[].set", expected: "a whole number, 1 to 1000", preset: "1", is_needed: false, unit: "" },
];
const text = 'schema = 1\nkind = "unloaded"\nname = "short"\n\n[perturbation]\namplitude_m = 0.005\nhold_s = [1.5, 2]\n\n[[posture]]\nname = "reference"\nposition_m = [0, 0.38]\n';
const document_ = { schema: 1, kind: "unloaded", name: "short", perturbation: { amplitude_m: 0.005, hold_s: [1.5, 2] }, posture: [{ name: "reference", position_m: [0, 0.38] }] };

/// As the checker: refuses an amplitude beyond its range and a posture without a place.
function check(body) {
  const answer = { is_accepted: true, kind: "unloaded", name: "short", problem: null, document: document_, preview: { trials: 12, duration_s: 61, postures: [], extremes: [] } };
  const refuse = (key, line, message) => ({ ...answer, is_accepted: false, preview: null, problem: { key, line, message } });
  if (/amplitude_m = 5/.test(body)) return refuse("perturbation.amplitude_m", 6, "perturbation.amplitude_m: 5 is not allowed; expected 0.0005 to 0.03 m");
  if ((body.match(/\[\[posture\]\]/g) ?? []).length > (body.match(/position_m/g) ?? []).length) return refuse("posture[2].position_m", 14, "posture[2].position_m is missing; expected [x, y], each -1 to 1 m");
  return answer;
}

/// A field out of range has the checker's message; a posture more; the text is what the form says, and goes to the start form.
async function editor({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 1, 5]) {
    gateway.forgetAll();
    desk.enter(named("ready"));
    const name = `protocol editor, ${looks[lookNumber].viewport.width}`;
    gateway.answers.set("/api/protocols", [{ name: "short", text }]);
    gateway.answers.set("/api/protocols/keys", keys);
    gateway.answers.set("/api/protocols/check", check);
    const page = await openPage(browser, gateway, "protocols", looks[lookNumber]);
    await says(page, "protocols", named("ready"), name);
    const verdict = (wanted) => until(async () => { const seen = await page.textContent("#preview"); return [seen === wanted, seen]; }, `${name}: says "${wanted}"`);
    await verdict("Accepted: 12 trials, about 1 min 01 s if none is repeated");
    await page.fill('[data-key="perturbation.amplitude_m"]', "5");
    await verdict("Not accepted: line 6: perturbation.amplitude_m: 5 is not allowed; expected 0.0005 to 0.03 m");
    const at = await page.evaluate(() => { const field = document.querySelector('[data-key="perturbation.amplitude_m"]'); return [field.getAttribute("aria-invalid"), document.getElementById(field.getAttribute("aria-describedby")).textContent].join(" "); });
    if (at !== "true perturbation.amplitude_m: 5 is not allowed; expected 0.0005 to 0.03 m") fail(`${name}: the message is at its field; seen: ${at}`);
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `protocols-${looks[lookNumber].viewport.width}.png`) });
    await page.fill('[data-key="perturbation.amplitude_m"]', "0.006");
    await page.click('[data-add="posture"]');
    await page.keyboard.type("distal");
    await verdict("Not accepted: line 14: posture[2].position_m is missing; expected [x, y], each -1 to 1 m");
    await page.fill('[data-key="posture[2].position_m"]', "0, 0.52");
    await page.selectOption('[data-key="confirm_posture"]', "true");
    await verdict("Accepted: 12 trials, about 1 min 01 s if none is repeated");
    const written = await page.textContent("#protocol-text");
    const wanted = 'schema = 1\nkind = "unloaded"\nname = "short"\nconfirm_posture = true\n\n[perturbation]\namplitude_m = 0.006\nhold_s = [1.5, 2]\n\n[[posture]]\nname = "reference"\nposition_m = [0, 0.38]\n\n[[posture]]\nname = "distal"\nposition_m = [0, 0.52]\n';
    if (written !== wanted) fail(`${name}: the text is what the form says; seen: ${JSON.stringify(written)}`);
    await page.selectOption('[data-key="kind"]', "loaded");
    await page.locator('[data-key="bias.sets_along"]').waitFor();
    await page.selectOption('[data-key="kind"]', "replay");
    await page.click('[data-add="recording"]');
    await page.keyboard.type("ankle");
    for (const set of [1, 2]) {
      await page.click('[data-add="recording[1].event"]');
      await page.fill(`[data-key="recording[1].event[${set}].set"]`, String(set));
    }
    await page.click('[data-remove="recording[1].event[1]"]');
    await until(async () => { const seen = await page.textContent("#protocol-text"); return [seen.endsWith('[[recording]]\nname = "ankle"\n\n[[recording.event]]\nset = 2\n'), seen]; }, `${name}: tables inside a list's tables are entered and written`);
    await page.click('[data-remove="recording[1]"]');
    await page.selectOption('[data-key="kind"]', "unloaded");
    await verdict("Accepted: 12 trials, about 1 min 01 s if none is repeated");
    await page.click("#use-protocol");
    await until(async () => { const seen = await page.evaluate(() => Array.from(document.querySelectorAll("#protocol option"), (one) => one.value).join()); return [seen.includes("edited: short"), seen]; }, `${name}: the form that starts a session offers it`);
    await page.context().close();
  }
}

/// An export with progress and its file; one that fails says why; a report.
async function exports_({ openPage, look, until, says, named, looks, screenshots, fail }, browser, gateway, desk, stops) {
  for (const lookNumber of [0, 5]) {
    gateway.forgetAll();
    desk.enter(named("completed"));
    const name = `exports, ${looks[lookNumber].viewport.width}`;
    const jobs = [];
    gateway.answers.set("/api/jobs", jobs);
    const order = (what) => (body, request) => {
      const query = new URL(request.url, "http://x").searchParams;
      jobs.push({ number: jobs.length + 1, what, subject: what === "export" ? `5a5a5a5a ${query.get("format")}` : query.get("name"), state: "running", done: 3, total: 40, message: "", path: what === "export" ? "/exports/tonus-5a5a5a5a-bids.tar" : "/reports/pilot/index.html" });
      return { job: jobs.length };
    };
    gateway.answers.set(`/api/sessions/${"5a".repeat(16)}/exports`, order("export"));
    const page = await openPage(browser, gateway, "archive", looks[lookNumber]);
    await page.locator("#session-facts[data-session]").waitFor();
    const lines = (wanted, what) => until(async () => { const seen = (await page.locator("#jobs li span").allTextContents()).map((one) => one.trim()); return [seen.join(" | ") === wanted, seen]; }, `${name}: ${what}`);
    await page.click('[data-export="bids"]');
    await lines("Export 5a5a5a5a bids: 3 of 40", "how far it is");
    jobs[0].state = "done";
    await lines("Export 5a5a5a5a bids: done", "it is done");
    const address = await page.locator("#jobs a").getAttribute("href");
    if (address !== "/exports/tonus-5a5a5a5a-bids.tar") fail(`${name}: the file can be had; seen: ${address}`);
    await page.click('[data-export="hdf5"]');
    await lines("Export 5a5a5a5a hdf5: 3 of 40 | Export 5a5a5a5a bids: done", "the next one");
    Object.assign(jobs[1], { state: "failed", message: "the disk is full", path: "" });
    await lines("Export 5a5a5a5a hdf5: failed: the disk is full | Export 5a5a5a5a bids: done", "why it failed");
    stops.add(await look(page, name));
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({ fullPage: true, path: join(screenshots, `archive-exports-${looks[lookNumber].viewport.width}.png`) });
    await page.context().close();
  }
}

module.exports = { scenarios: [studies, editor, exports_] };
