// A gateway whose bus is a script: serves the built pages and speaks the gateway's protocol, with messages that a test
// gives. What is left out of a message is zero or empty.
//
//   const gateway = await ScriptedGateway.start({ packages, pages, idl });
//   gateway.say("rig/state", { mode: 1 });

const { createRequire } = require("node:module");
const { readFileSync, readdirSync, existsSync } = require("node:fs");
const { createServer } = require("node:http");
const { extname, join } = require("node:path");

const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".json": "application/json" };
const topics = {
  "service/health": "ServiceHealth", "session/state": "SessionState", "session/plan": "SessionPlan", "session/cue": "SessionCue",
  "rig/state": "RigState", "rig/description": "RigDescription", "rig/samples": "SampleBlock", "trial/command": "TrialCommand",
  "trial/outcome": "TrialOutcome", "trial/verdict": "TrialVerdict", "trial/review": "TrialReview", "estimate/condition": "Estimate",
  "session/note": "SessionNote", "rig/auxiliary": "AuxiliaryBlock",
};

class ScriptedGateway {
  #clients = new Set();
  #kept = []; // what a page that comes later is told
  #channels = [];
  #writers = new Map();
  #definitions = new Map();
  #sockets;
  #http;
  #options;
  /// Answers to HTTP requests by path: objects become JSON, buffers go as they are, functions get the request's body.
  answers = new Map([["/api/protocols", []], ["/api/sessions", []], ["/api/subjects", []], ["/api/studies", []], ["/api/jobs", []], ["/api/reports", []], ["/api/role", { role: "operate" }]]);
  requests = [];
  /// What becomes of a request of a page: a reply, or undefined for silence.
  reply = (request) => ({ request_id: request.request_id, request: request.request, is_done: true, message: "done", requested_by: "test" });
  isDown = false; // takes no connection
  isSilent = false; // no status: as a gateway that hangs

  static async start(options) {
    const gateway = new ScriptedGateway(options);
    await new Promise((resolve) => gateway.#http.listen(0, "127.0.0.1", resolve));
    return gateway;
  }

  constructor(options) {
    this.#options = options;
    const require = createRequire(join(options.packages, "package.json"));
    const { WebSocketServer } = require("ws");
    this.#readContract(require);
    this.#http = createServer((request, response) => this.#serve(request, response));
    this.#sockets = new WebSocketServer({ server: this.#http, handleProtocols: () => "foxglove.websocket.v1" });
    this.#sockets.on("connection", (socket) => this.#welcome(socket));
    this.statusTimer = setInterval(() => this.#status(), 500);
  }

  get url() {
    return `http://127.0.0.1:${this.#http.address().port}`;
  }

  #readContract(require) {
    const { parseIDL } = require("@foxglove/omgidl-parser");
    const { MessageWriter } = require("@foxglove/omgidl-serialization");
    for (const file of readdirSync(this.#options.idl).filter((name) => name.endsWith(".idl"))) {
      const text = readFileSync(join(this.#options.idl, file), "utf8");
      const definitions = parseIDL(text);
      for (const one of definitions) this.#definitions.set(one.name, one);
      for (const [topic, type] of Object.entries(topics)) {
        const name = `tonus::v1::${type}`;
        if (!definitions.some((one) => one.name === name)) continue;
        this.#channels.push({ id: this.#channels.length + 1, topic, encoding: "cdr", schemaName: name, schema: text, schemaEncoding: "omgidl" });
        this.#writers.set(topic, { writer: new MessageWriter(name, definitions), name });
      }
    }
    for (const topic of ["gateway/status", "operator/reply"])
      this.#channels.push({ id: this.#channels.length + 1, topic, encoding: "json", schemaName: topic, schema: "{}", schemaEncoding: "jsonschema" });
  }

  /// The value with everything that it leaves out.
  whole(type, value = {}) {
    const definition = this.#definitions.get(type);
    const filled = {};
    for (const field of definition.definitions) filled[field.name] = this.#field(field, value[field.name]);
    return filled;
  }

  #field(field, value) {
    const one = (given) => {
      if (field.isComplex) return this.whole(field.type, given);
      if (given !== undefined) return given;
      if (field.type === "string") return "";
      if (field.type === "bool") return false;
      return /int64/.test(field.type) ? 0n : 0;
    };
    if (field.arrayLengths) return Array.from({ length: field.arrayLengths[0] }, (_, i) => one(value?.[i]));
    if (field.isArray) return Array.from(value ?? [], one);
    return one(value);
  }

  encode(topic, value) {
    const { writer, name } = this.#writers.get(topic);
    return Buffer.from(writer.writeMessage(this.whole(name, value)));
  }

  /// Publishes, and keeps it for late joiners, one message for each topic and key.
  say(topic, value, { key = "", ageMs = 0, isKept = true } = {}) {
    const message = { topic, key, at: Date.now() - ageMs, data: this.encode(topic, value) };
    if (isKept) {
      this.#kept = this.#kept.filter((one) => one.topic !== topic || one.key !== key);
      this.#kept.push(message);
    }
    for (const client of this.#clients) this.#send(client, message);
  }

  forget(topic, key = "") {
    this.#kept = this.#kept.filter((one) => one.topic !== topic || one.key !== key);
  }

  forgetAll() {
    this.#kept = [];
  }

  drop(reason = "") {
    for (const client of this.#clients) client.socket.close(1001, reason);
  }

  #welcome(socket) {
    if (this.isDown) return socket.close(1001, "the gateway ends");
    const client = { socket, subscriptions: new Map() };
    this.#clients.add(client);
    socket.on("close", () => this.#clients.delete(client));
    socket.on("message", (data, isBinary) => (isBinary ? this.#take(data) : this.#hear(client, JSON.parse(data))));
    socket.send(JSON.stringify({ op: "serverInfo", name: "scripted", capabilities: ["clientPublish"], supportedEncodings: ["json"], metadata: { role: "operate" } }));
    socket.send(JSON.stringify({ op: "advertise", channels: this.#channels }));
  }

  #hear(client, saying) {
    if (saying.op !== "subscribe") return;
    for (const { id, channelId } of saying.subscriptions) {
      const { topic } = this.#channels.find((channel) => channel.id === channelId);
      client.subscriptions.set(topic, id);
      for (const message of this.#kept.filter((one) => one.topic === topic)) this.#send(client, message);
    }
  }

  #take(data) {
    const request = JSON.parse(data.subarray(5).toString());
    this.requests.push(request);
    const reply = this.reply(request);
    if (reply) this.#sayJson("operator/reply", reply);
  }

  #status() {
    if (!this.isSilent) this.#sayJson("gateway/status", { utc_ns: 0, clients: [], thinned: 0, arrival_drops: 0 });
  }

  #sayJson(topic, value) {
    for (const client of this.#clients) this.#send(client, { topic, at: Date.now(), data: Buffer.from(JSON.stringify(value)) });
  }

  #send(client, { topic, at, data }) {
    const id = client.subscriptions.get(topic);
    if (id === undefined) return;
    const head = Buffer.alloc(13);
    head.writeUInt8(1, 0);
    head.writeUInt32LE(id, 1);
    head.writeBigUInt64LE(BigInt(at) * 1_000_000n, 5);
    client.socket.send(Buffer.concat([head, data]));
  }

  #serve(request, response) {
    const path = new URL(request.url, "http://x").pathname;
    const answer = this.answers.get(request.url) ?? this.answers.get(path);
    if (typeof answer === "function") {
      const parts = [];
      request.on("data", (part) => parts.push(part));
      request.on("end", () => response.writeHead(200, { "Content-Type": "application/json" }).end(JSON.stringify(answer(Buffer.concat(parts).toString(), request))));
      return undefined;
    }
    if (answer !== undefined) {
      const isRaw = Buffer.isBuffer(answer);
      response.writeHead(200, { "Content-Type": isRaw ? "application/octet-stream" : "application/json" });
      return response.end(isRaw ? answer : JSON.stringify(answer));
    }
    const file = [path === "/" ? "/index.html" : path, `${path}.html`].map((name) => join(this.#options.pages, name)).find((name) => existsSync(name) && extname(name));
    if (!file) return response.writeHead(404, { "Content-Type": "application/json" }).end('{"error": "there is no such page"}');
    response.writeHead(200, { "Content-Type": types[extname(file)] ?? "application/octet-stream" });
    response.end(readFileSync(file));
  }

  async stop() {
    clearInterval(this.statusTimer);
    for (const client of this.#clients) client.socket.terminate();
    await new Promise((resolve) => this.#http.close(resolve));
  }
}

module.exports = { ScriptedGateway };
