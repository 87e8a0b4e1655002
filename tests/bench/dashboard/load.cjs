// See ./run.

const { createRequire } = require("node:module");
const { spawn, execFileSync } = require("node:child_process");
const { readFileSync } = require("node:fs");
const { createInterface } = require("node:readline");
const { createServer } = require("node:net");
const { randomBytes } = require("node:crypto");

const [packages, programs, here, data, domain] = process.argv.slice(2);
const load = createRequire(`${packages}/package.json`);
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const { parseIDL } = load("@foxglove/omgidl-parser");
const { MessageReader } = load("@foxglove/omgidl-serialization");
const WebSocket = load("ws");
const TRIALS_EACH = 3;

const children = [];
function start(program, args, options = {}) {
  const child = spawn(program, args, { stdio: ["pipe", "pipe", "inherit"], ...options });
  children.push(child);
  return child;
}
const lines = (child) => createInterface({ input: child.stdout });

function freePort() {
  return new Promise((resolve) => {
    const server = createServer().listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? NaN;

function gatewayProcess(system) {
  const list = execFileSync("ps", ["-o", "pid=,comm=", "--ppid", String(system.pid)], { encoding: "utf8" });
  return Number(list.split("\n").find((line) => line.includes("tonus-dashboar")).trim().split(/\s+/)[0]);
}

const memory = (pid, key) => Number(/(\d+)/.exec(readFileSync(`/proc/${pid}/status`, "utf8").split(key)[1])[1]) / 1024;
const cpuSeconds = (pid) => {
  const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1].split(" ");
  return (Number(fields[11]) + Number(fields[12])) / 100;
};

async function main() {
  const listen = `127.0.0.1:${await freePort()}`;
  const url = `ws://${listen}`;
  const system = start(`${programs}/tonus`, [
    "up", "--dashboard", "--dashboard-listen", listen, "--domain", domain, "--data", data, "--speed", "real",
    "--profile", `${here}/profile.toml`,
  ]);
  await new Promise((resolve, reject) => {
    lines(system).on("line", (line) => line.startsWith("dashboard serves") && resolve());
    system.on("exit", () => reject(new Error("tonus up has ended")));
  });
  const crowd = start("nice", ["-n", "19", "node", `${here}/clients.cjs`, packages, url]);
  let received = { messages: 0, bytes: 0 };
  lines(crowd).on("line", (line) => (received = JSON.parse(line)));

  const pid = gatewayProcess(system);
  const groups = {
    alone: { latencies: [], overruns: 0n, samples: 0n, late: new Array(18).fill(0n), cpu: 0, seconds: 0 },
    crowd: { latencies: [], overruns: 0n, samples: 0n, late: new Array(18).fill(0n), cpu: 0, seconds: 0 },
  };
  let current = "alone";
  let trialsHere = -1; // the first one is for warming up
  let rig, rigAtSwitch, timing, timingAtSwitch, status;
  let [cpuAtSwitch, switchedAt] = [cpuSeconds(pid), Date.now()];
  const outcomes = new Map();
  const latest = { memory: memory(pid, "VmRSS:") };
  const memoryAtBegin = latest.memory;
  let memoryMost = 0;

  function settle() {
    const group = groups[current];
    if (rig && rigAtSwitch) {
      group.overruns += rig.overruns - rigAtSwitch.overruns;
      group.samples += rig.next_sequence - rigAtSwitch.next_sequence;
    }
    if (timing && timingAtSwitch)
      timing.lateness_count.forEach((count, i) => (group.late[i] += count - timingAtSwitch.lateness_count[i]));
    group.cpu += cpuSeconds(pid) - cpuAtSwitch;
    group.seconds += (Date.now() - switchedAt) / 1000;
    [rigAtSwitch, timingAtSwitch, cpuAtSwitch, switchedAt] = [rig, timing, cpuSeconds(pid), Date.now()];
  }

  function change() {
    settle();
    current = current === "alone" ? "crowd" : "alone";
    trialsHere = -1; // the trial that runs has both
    crowd.stdin.write(current === "crowd" ? "on\n" : "off\n");
  }

  const readers = new Map();
  const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const wanted = ["trial/outcome", "trial/verdict", "session/state", "rig/state", "rig/timing", "gateway/status", "operator/reply"];
  const finished = new Promise((resolve, reject) => {
    client.on("close", () => reject(new Error("the gateway has closed the connection")));
    client.on("message", ({ subscriptionId, timestamp, data: payload }) => {
      const { topic, read } = readers.get(subscriptionId);
      const message = read(payload);
      if (topic === "rig/state") rig = message;
      if (topic === "rig/timing") timing = message;
      if (topic === "gateway/status") {
        status = message;
        memoryMost = Math.max(memoryMost, memory(pid, "VmRSS:"));
      }
      if (topic === "trial/outcome") outcomes.set(Buffer.from(message.trial_id).toString("hex"), timestamp);
      if (topic === "trial/verdict") {
        const begun = outcomes.get(Buffer.from(message.trial_id).toString("hex"));
        if (begun !== undefined && trialsHere >= 0) groups[current].latencies.push(Number(timestamp - begun) / 1e6);
        trialsHere += 1;
        if (trialsHere >= TRIALS_EACH) change();
        process.stderr.write(`\rtrials: ${outcomes.size} `);
      }
      if (topic === "operator/reply" && !message.is_done) reject(new Error(message.message));
      if (topic === "session/state" && message.phase === 7) resolve();
      if (topic === "session/state" && message.phase > 7) reject(new Error(message.message));
      if (topic === "session/state" && message.phase === 5 && message.waiting_for.startsWith("operator"))
        reject(new Error(`the session waits for ${message.waiting_for}`));
    });
  });
  client.on("advertise", (channels) => {
    for (const { id, topic, encoding, schemaName, schema } of channels) {
      if (!wanted.includes(topic)) continue;
      const reader = encoding === "cdr" ? new MessageReader(schemaName, parseIDL(schema)) : undefined;
      const read = reader ? (bytes) => reader.readMessage(bytes) : (bytes) => JSON.parse(new TextDecoder().decode(bytes));
      readers.set(client.subscribe(id), { topic, read });
    }
    const asking = client.advertise({ topic: "operator/request", encoding: "json", schemaName: "tonus.OperatorRequest" });
    const request = {
      request_id: randomBytes(16).toString("hex"), request: "start", session_id: randomBytes(16).toString("hex"),
      protocol_toml: readFileSync(`${here}/perturbations.toml`, "utf8"), subject: "sub-01", seed: 1,
    };
    client.sendMessage(asking, new TextEncoder().encode(JSON.stringify(request)));
  });
  await finished;
  settle();
  process.stderr.write("\r                \r");

  console.log("latency: from the publication of a trial's outcome to that of its verdict, ms");
  for (const [name, group] of Object.entries(groups)) {
    const sorted = group.latencies.sort((a, b) => a - b);
    const cycles = group.late.reduce((sum, count) => sum + count, 0n);
    const beyond = group.late.slice(11).reduce((sum, count) => sum + count, 0n); // bins from 2^10 us
    console.log(
      `${name.padEnd(6)} ${sorted.length} trials: median ${quantile(sorted, 0.5).toFixed(2)}, 90 % ${quantile(sorted, 0.9).toFixed(2)}, ` +
        `most ${quantile(sorted, 1).toFixed(2)}; rig: ${group.samples} samples, ${group.overruns} periods missed` +
        (cycles > 0n ? `, ${((1e6 * Number(beyond)) / Number(cycles)).toFixed(0)} of 1e6 cycles over 1 ms late` : "") +
        `; gateway: ${((100 * group.cpu) / group.seconds).toFixed(1)} % of one processor`,
    );
  }
  const median = (name) => quantile(groups[name].latencies, 0.5);
  const missed = (name) => Number(groups[name].overruns) / Math.max(1, Number(groups[name].samples));
  console.log(`ratio with clients / without: latency ${(median("crowd") / median("alone")).toFixed(3)}`);
  console.log(`periods missed per sample: ${missed("alone").toExponential(2)} alone, ${missed("crowd").toExponential(2)} with clients`);
  console.log(
    `gateway: ${memoryAtBegin.toFixed(1)} MB at the begin, ${memoryMost.toFixed(1)} MB at most, ${memory(pid, "VmRSS:").toFixed(1)} MB at the end; ` +
      `${status.thinned} live messages thinned, refused: ${JSON.stringify(status.refused)}; clients got ${received.messages} messages, ${(received.bytes / 1e6).toFixed(1)} MB`,
  );
  client.close();
}

main()
  .catch((error) => {
    console.error(`load: ${error.message}`);
    process.exitCode = 1;
  })
  .finally(() => {
    for (const child of children) child.kill("SIGTERM");
    setTimeout(() => process.exit(), 3000).unref();
  });
