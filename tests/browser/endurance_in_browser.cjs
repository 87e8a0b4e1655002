// The operator's page for minutes beside a rig of 1 kHz, trial after trial: frames a second of its traces beside those of an
// empty page in the same browser, and what it keeps in memory. Behind it is a scripted gateway.
//
//   node endurance_in_browser.cjs PACKAGES CHROMIUM PAGES IDL [MINUTES]
//
// Ends with 1 where the page's heap grows after the first tenth of the time, or its document by more than the lines of the trials.

const { createRequire } = require("node:module");
const { join } = require("node:path");
const { ScriptedGateway } = require("./scripted_gateway.cjs");
const { states, Desk, SESSION, RIG, id } = require("./desk_states.cjs");

const [packages, executablePath, pages, idl, minutes = "20"] = process.argv.slice(2);
const { chromium } = createRequire(join(packages, "package.json"))("playwright-core");
const LENGTH_S = 60 * Number(minutes);
const LOOKS = 20;
const RATE_HZ = 1000;
const BLOCK = 25; // samples
const TRIAL_S = 4; // 2.5 s of rest, then a push
const MOST_GROWTH = 0.1;
const LEAST_SLACK_BYTES = 4e6; // what a garbage collector may leave
const LEAST_SLACK_NODES = 500;
const NODES_OF_A_TRIAL = 12; // a line of the verdicts

/// Samples, commands, outcomes and verdicts, as far as the clock says that they are due.
class Rig {
  #gateway;
  #begin = Date.now();
  #sent = 0;
  #attempt = 0;
  samples = 0;
  trials = 0;

  constructor(gateway) {
    this.#gateway = gateway;
  }

  go() {
    const due = Math.floor(((Date.now() - this.#begin) / 1000) * RATE_HZ);
    while (this.#sent + BLOCK <= due) this.#block();
    this.samples = this.#sent;
    this.trials = this.#attempt;
  }

  #block() {
    const attempt = 1 + Math.floor(this.#sent / (TRIAL_S * RATE_HZ));
    if (attempt !== this.#attempt) this.#change(attempt);
    const samples = Array.from({ length: BLOCK }, (_, i) => {
      const number = this.#sent + i;
      const time = (number / RATE_HZ) % TRIAL_S;
      const rise = Math.min(1, Math.max(0, (time - 2.5) / 0.2));
      const noise = Math.sin(0.37 * number) + Math.sin(0.011 * number);
      return { acquisition_ns: 10_000_000_000n + BigInt(number) * BigInt(1e9 / RATE_HZ), encoder_count: [100 * rise + noise, 15708 + 50 * rise], force_V: [0.1 * rise + 0.001 * noise, -0.02 * rise], phase: rise > 0 ? 5 : 2 };
    });
    this.#gateway.say("rig/samples", { rig_id: RIG, session_id: SESSION, trial_id: this.#trial(attempt), epoch: 1n, first_sequence: BigInt(this.#sent), samples }, { isKept: false });
    this.#sent += BLOCK;
  }

  #trial(attempt) {
    return id(0x30).map((byte, i) => (i === 14 ? attempt >> 8 : i === 15 ? attempt & 255 : byte));
  }

  #change(attempt) {
    const program = (number) => ({ session_id: SESSION, rig_id: RIG, attempt: number, posture: "reference", posture_index: 0, posture_m: [0, 0.38], set_number: 1, amplitude_m: 0.005 });
    const say = (topic, value) => this.#gateway.say(topic, value, { isKept: false });
    const former = this.#attempt;
    this.#attempt = attempt;
    if (former > 0) {
      say("trial/outcome", { trial_id: this.#trial(former), program: program(former), epoch: 1n });
      say("trial/verdict", { trial_id: this.#trial(former), session_id: SESSION, attempt: former, is_valid: true, detail: "valid: start 1.2 mm (limit 5.0), rest 3.0 mm/s (20.0) and 0.10 N (1.00), moved 6.1 mm (15.0), end 2.0 mm/s (25.0)" });
    }
    say("trial/command", { trial_id: this.#trial(attempt), program: program(attempt) });
  }
}

async function memoryOf(page) {
  const devtools = await page.context().newCDPSession(page);
  await devtools.send("HeapProfiler.collectGarbage");
  const { usedSize } = await devtools.send("Runtime.getHeapUsage");
  const { nodes } = await devtools.send("Memory.getDOMCounters");
  await devtools.detach();
  return { heap: usedSize, nodes };
}

const framesOf = async (page, empty) => ({
  traces: await page.evaluate(() => Number(document.querySelector(".trace").dataset.frames)),
  empty: await empty.evaluate(() => globalThis.frames_drawn),
  at: Date.now(),
});

function growth(seen, of) {
  const begin = of(seen[Math.max(1, Math.floor(seen.length / 10))]);
  return { begin, end: of(seen.at(-1)), grown: of(seen.at(-1)) - begin };
}

async function run() {
  const gateway = await ScriptedGateway.start({ packages, pages, idl });
  const browser = await chromium.launch({ executablePath });
  const desk = new Desk(gateway);
  desk.enter(states.find(({ name }) => name === "running"));
  const rig = new Rig(gateway);
  const feeding = setInterval(() => rig.go(), 5);
  try {
    const page = await (await browser.newContext({ viewport: { width: 1280, height: 720 } })).newPage();
    const faults = [];
    page.on("pageerror", (error) => faults.push(error.message));
    await page.goto(`${gateway.url}/`);
    await page.waitForFunction(() => Number(document.querySelector(".trace")?.dataset.frames) > 10, undefined, { timeout: 30000 });
    const empty = await (await browser.newContext()).newPage();
    await empty.evaluate(() => {
      globalThis.frames_drawn = 0;
      const count = () => { globalThis.frames_drawn += 1; requestAnimationFrame(count); };
      count();
    });
    const seen = [];
    const first = await framesOf(page, empty);
    let former = first;
    for (let look = 0; look <= LOOKS; look += 1) {
      if (look > 0) await page.waitForTimeout((1000 * LENGTH_S) / LOOKS);
      const now = await framesOf(page, empty);
      const seconds = (now.at - former.at) / 1000;
      seen.push(await memoryOf(page));
      if (look > 0)
        console.log(`${((look * LENGTH_S) / LOOKS).toFixed(0)} s: ${((now.traces - former.traces) / seconds).toFixed(1)} frames/s (empty page ${((now.empty - former.empty) / seconds).toFixed(1)}), heap ${(seen.at(-1).heap / 1e6).toFixed(1)} MB, ${seen.at(-1).nodes} nodes`);
      former = await framesOf(page, empty);
    }
    const heap = growth(seen, (one) => one.heap);
    const nodes = growth(seen, (one) => one.nodes);
    const share = (former.traces - first.traces) / (former.empty - first.empty);
    console.log(`${rig.samples} samples in ${LENGTH_S} s; traces drew ${(100 * share).toFixed(1)} % of the frames of an empty page; heap ${(heap.begin / 1e6).toFixed(1)} to ${(heap.end / 1e6).toFixed(1)} MB, nodes ${nodes.begin} to ${nodes.end}`);
    if (heap.grown > Math.max(LEAST_SLACK_BYTES, MOST_GROWTH * heap.begin)) faults.push(`the heap grew by ${(heap.grown / 1e6).toFixed(1)} MB`);
    const most = NODES_OF_A_TRIAL * rig.trials + LEAST_SLACK_NODES;
    if (nodes.grown > most) faults.push(`the document grew by ${nodes.grown} nodes; expected at most ${most} for ${rig.trials} trials`);
    for (const fault of faults) console.error(`not so: ${fault}`);
    return faults.length === 0 ? 0 : 1;
  } finally {
    clearInterval(feeding);
    desk.end();
    await browser.close();
    await gateway.stop();
  }
}

run().then((code) => process.exit(code), (error) => { console.error(error); process.exit(1); });
