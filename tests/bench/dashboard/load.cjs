// See ./run.

const { report } = require("./report.cjs");
const { start, endAll, ask, startSystem, watch, startSession } = require("./system.cjs");
const { child, megabytes, cpuSeconds, keepOn, realtimeThread, waited } = require("./threads.cjs");

const [packages, programs, here, data, domain, pairsWanted, placing] = process.argv.slice(2);
const PAIRS = Number(pairsWanted);
const BLOCK_S = 4; // of which each has one more second, before it, for clients to come or go
const COMPLETED = 7; // of session/state
const WAITING = 5;
const ORDER = [false, true, true, false]; // with clients? AB BA AB BA ...

const minus = (a, b) => Array.from(a, (count, i) => Number(count) - Number(b[i]));

async function main() {
  const system = await startSystem(programs, here, data, domain);
  const isApart = placing === "apart";
  const crowd = start("nice", ["-n", "19", ...(isApart ? ["taskset", "-c", "0"] : []), "node", `${here}/clients.cjs`, packages, system.url]);
  const bare = start(`${programs}/rig_bare_timer`, ["--rate", "1000", ...(isApart ? ["--cpu", "1"] : [])]);
  const gateway = child(system.pid, "tonus-dashboar");
  const rig = child(system.pid, "tonus-rig-agent");
  const loop = realtimeThread(rig);
  if (isApart && loop) keepOn(1, loop);

  const blocks = [];
  let clients = { messages: 0, bytes: 0 };
  let block; // the one that is measured, or about to be
  let status;
  const memory = { begin: megabytes(gateway, "VmRSS:"), most: 0 };

  /// Everything that only grows, at one moment.
  async function reading(timing) {
    return {
      loop: timing.lateness_count, missed: Number(timing.missed_periods), cycles: Number(timing.cycles),
      bare: await ask(bare, ""), waited: loop ? waited(rig, loop) : NaN, cpu: cpuSeconds(gateway), at: Date.now(),
    };
  }

  function close(now) {
    const { begin, isWithClients, latencies } = block;
    blocks.push({
      isWithClients, latencies,
      loop: minus(now.loop, begin.loop), bare: minus(now.bare.lateness_count, begin.bare.lateness_count),
      cycles: now.cycles - begin.cycles, missed: now.missed - begin.missed,
      bareMissed: now.bare.missed_periods - begin.bare.missed_periods, bareCycles: now.bare.cycles - begin.bare.cycles,
      waited: (now.waited - begin.waited) / (now.cycles - begin.cycles),
      cpu: (now.cpu - begin.cpu) / ((now.at - begin.at) / 1000),
    });
    process.stderr.write(`\r${blocks.length} of ${2 * PAIRS} blocks `);
  }

  async function open() {
    const isWithClients = ORDER[blocks.length % ORDER.length];
    if (isWithClients !== (block?.isWithClients ?? false)) clients = await ask(crowd, isWithClients ? "on" : "off");
    block = { isWithClients, seconds: -1, latencies: [] };
  }

  const outcomes = new Map();
  let scheduling = "";
  let finish;
  const finished = new Promise((resolve, reject) => {
    finish = (error) => (error ? reject(error) : resolve());
  });
  const idOf = (message) => Buffer.from(message.trial_id).toString("hex");
  let isBusy = false;
  const client = await watch(packages, system.url, {
    "rig/timing": async (timing) => {
      scheduling = timing.scheduling;
      if (!block || isBusy) return;
      isBusy = true;
      block.seconds += 1;
      if (block.seconds === 0) block.begin = await reading(timing);
      if (block.seconds === BLOCK_S) {
        close(await reading(timing));
        if (blocks.length === 2 * PAIRS) return finish();
        await open();
      }
      isBusy = false;
    },
    "gateway/status": (message) => {
      status = message;
      memory.most = Math.max(memory.most, megabytes(gateway, "VmRSS:"));
    },
    "trial/outcome": (message, time) => outcomes.set(idOf(message), time),
    "trial/verdict": (message, time) => {
      const begun = outcomes.get(idOf(message));
      if (begun === undefined || !block) return;
      if (block.begin) block.latencies.push(Number(time - begun) / 1e6);
    },
    "session/state": (message) => {
      if (message.phase >= COMPLETED) finish(new Error(`the session is over: ${message.message}`));
      if (message.phase === WAITING && message.waiting_for.startsWith("operator"))
        finish(new Error(`the session waits for ${message.waiting_for}`));
      if (message.counted >= 1 && !block) void open(); // the first trial is for warming up
    },
    "operator/reply": (message) => message.is_done || finish(new Error(message.message)),
    end: (error) => finish(error),
  });
  startSession(client, `${here}/perturbations.toml`);
  await finished;
  process.stderr.write("\r                      \r");
  console.log(`${scheduling}${loop ? "; the loop's thread has SCHED_FIFO" : "; NO thread of the rig has SCHED_FIFO"}`);
  console.log(
    `${PAIRS} pairs of blocks of ${BLOCK_S} s without and with 20 clients${isApart ? ", these on processor 0, loop and bare timer on 1" : ""}\n`,
  );
  report(blocks);
  console.log(
    `gateway: ${memory.begin.toFixed(1)} MB at the begin, ${memory.most.toFixed(1)} MB at most, ${megabytes(gateway, "VmRSS:").toFixed(1)} MB at the end; ` +
      `${status.thinned} live messages thinned, refused: ${JSON.stringify(status.refused)}; clients got ${clients.messages} messages, ${(clients.bytes / 1e6).toFixed(1)} MB`,
  );
}

process.once("uncaughtException", (error) => {
  console.error(error.stack);
  endAll();
  process.exit(1);
});
main()
  .catch((error) => {
    console.error(`load: ${error.message}`);
    process.exitCode = 1;
  })
  .finally(() => {
    endAll();
    setTimeout(() => process.exit(), 3000).unref();
  });
