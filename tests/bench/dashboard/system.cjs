// The system under load: `tonus up --dashboard`, a session that is asked for over the gateway, what comes of it.

const { createRequire } = require("node:module");
const { spawn } = require("node:child_process");
const { readFileSync } = require("node:fs");
const { createInterface } = require("node:readline");
const { createServer } = require("node:net");
const { randomBytes } = require("node:crypto");

const children = [];
function start(program, args) {
  const child = spawn(program, args, { stdio: ["pipe", "pipe", "inherit"] });
  children.push(child);
  return child;
}
const endAll = () => children.forEach((child) => child.kill("SIGTERM"));
const lines = (child) => createInterface({ input: child.stdout });

/// Asks a child with a line; the answer is its next line, as JSON.
function ask(child, question) {
  child.answers ??= lines(child)[Symbol.asyncIterator]();
  child.stdin.write(`${question}\n`);
  return child.answers.next().then(({ value }) => JSON.parse(value));
}

function freePort() {
  return new Promise((resolve) => {
    const server = createServer().listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

async function startSystem(programs, here, data, domain) {
  const listen = `127.0.0.1:${await freePort()}`;
  const system = start(`${programs}/tonus`, [
    "up", "--dashboard", "--dashboard-listen", listen, "--domain", domain, "--data", data, "--speed", "real", "--resume-unattended",
    "--profile", `${here}/profile.toml`,
  ]);
  await new Promise((resolve, reject) => {
    lines(system).on("line", (line) => line.startsWith("dashboard serves") && resolve());
    system.on("exit", () => reject(new Error("tonus up has ended")));
  });
  return { url: `ws://${listen}`, pid: system.pid };
}

/// Calls on[topic](message, time in ns) for each message of these topics; resolves when all are subscribed to.
function watch(packages, url, on) {
  const load = createRequire(`${packages}/package.json`);
  const { FoxgloveClient } = load("@foxglove/ws-protocol");
  const { parseIDL } = load("@foxglove/omgidl-parser");
  const { MessageReader } = load("@foxglove/omgidl-serialization");
  const WebSocket = load("ws");
  const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
  const readers = new Map();
  client.on("message", ({ subscriptionId, timestamp, data }) => {
    const { topic, read } = readers.get(subscriptionId);
    on[topic](read(data), timestamp);
  });
  client.on("close", () => on.end?.(new Error("the gateway has closed the connection")));
  return new Promise((resolve) => {
    client.on("advertise", (channels) => {
      for (const { id, topic, encoding, schemaName, schema } of channels) {
        if (!on[topic]) continue;
        const reader = encoding === "cdr" ? new MessageReader(schemaName, parseIDL(schema)) : undefined;
        const read = reader ? (bytes) => reader.readMessage(bytes) : (bytes) => JSON.parse(new TextDecoder().decode(bytes));
        readers.set(client.subscribe(id), { topic, read });
      }
      resolve(client);
    });
  });
}

function startSession(client, protocolFile) {
  const channel = client.advertise({ topic: "operator/request", encoding: "json", schemaName: "tonus.OperatorRequest" });
  const request = {
    request_id: randomBytes(16).toString("hex"), request: "start", session_id: randomBytes(16).toString("hex"),
    protocol_toml: readFileSync(protocolFile, "utf8"), subject: "sub-01", seed: 1,
  };
  client.sendMessage(channel, new TextEncoder().encode(JSON.stringify(request)));
}

module.exports = { start, endAll, ask, startSystem, watch, startSession };
