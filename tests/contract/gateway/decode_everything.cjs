// Subscribes to every channel of a gateway with @foxglove/ws-protocol and decodes every message with
// @foxglove/omgidl-serialization by the schema that the channel brings.
//
//   node decode_everything.cjs PACKAGES URL EXPECTED.json    until each topic's message has come and is as expected
//   node decode_everything.cjs PACKAGES URL --watch          for good

const { createRequire } = require("node:module");
const { readFileSync } = require("node:fs");
const { isDeepStrictEqual } = require("node:util");

const [packages, url, mode] = process.argv.slice(2);
const load = createRequire(`${packages}/package.json`);
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const { parseIDL } = load("@foxglove/omgidl-parser");
const { MessageReader, MessageWriter } = load("@foxglove/omgidl-serialization");
const WebSocket = load("ws");

const expected = mode === "--watch" ? {} : JSON.parse(readFileSync(mode, "utf8"));
const missing = new Set([...Object.keys(expected), ...(mode === "--watch" ? [] : ["gateway/status", "operator/reply"])]);
const channels = new Map();
let failures = 0;

function fail(text) {
  console.error(text);
  failures += 1;
}

const at = (value, path) => path.split(".").reduce((inner, name) => inner?.[name], value);

const isAscii = (value) =>
  typeof value === "string"
    ? /^[\x00-\x7f]*$/.test(value)
    : typeof value !== "object" || Object.values(value).every(isAscii);

function check(topic, { reader, writer }, data) {
  const { values, payload } = expected[topic];
  const bytes = Buffer.from(data.buffer, data.byteOffset, data.byteLength);
  if (bytes.toString("hex") !== payload) return; // somebody else's: the gateway's own health, say
  const message = reader.readMessage(data);
  for (const [path, value] of Object.entries(values)) {
    const found = String(at(message, path));
    if (found !== value) fail(`${topic}: ${path} is ${found}, expected ${value}`);
  }
  // Encoding it again gives as many bytes with the same content: nothing was passed over or read twice. (Bytes that
  // only align the next member may differ.)
  // The packages' own writer counts a text's characters where its bytes are meant: such a message is only read.
  if (!isAscii(message)) return missing.delete(topic);
  const again = writer.writeMessage(message);
  if (bytes.length - again.byteLength > 3 || again.byteLength > bytes.length)
    fail(`${topic}: ${again.byteLength} bytes when encoded again, ${bytes.length} came`);
  if (!isDeepStrictEqual(reader.readMessage(again), message)) fail(`${topic}: changed when encoded again`);
  missing.delete(topic);
}

/// A schema that Lichtblick and Foxglove read, and a value that is as it says: every object names its properties.
function checkJson(where, schema, value) {
  const kind = { integer: "number" }[schema.type] ?? schema.type;
  if (schema.type === "array") {
    if (!Array.isArray(value)) return fail(`${where}: ${JSON.stringify(value)} is no array`);
    return value.forEach((item, i) => checkJson(`${where}[${i}]`, schema.items, item));
  }
  if (!["object", "string", "number", "boolean"].includes(kind) || typeof value !== kind)
    return fail(`${where}: ${JSON.stringify(value)} is no ${schema.type}`);
  if (kind !== "object") return;
  const names = Object.keys(schema.properties ?? {}).sort();
  if (!isDeepStrictEqual(names, Object.keys(value).sort())) return fail(`${where}: has ${Object.keys(value)}, its schema ${names}`);
  for (const name of names) checkJson(`${where}.${name}`, schema.properties[name], value[name]);
}

function finishIfDone() {
  if (failures > 0) process.exit(1);
  if (missing.size === 0 && mode !== "--watch") process.exit(0);
}

const client = new FoxgloveClient({
  ws: new WebSocket(url.replace("http", "ws"), [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
client.on("error", (error) => fail(`connection: ${error}`));
client.on("close", () => process.exit(1));
client.on("status", (status) => fail(`status: ${status.message}`));
client.on("serverInfo", (info) => {
  if (!info.capabilities.includes("clientPublish") || !info.supportedEncodings.includes("json") || !info.sessionId)
    fail(`serverInfo: ${JSON.stringify(info)}`);
});
client.on("advertise", (list) => {
  for (const channel of list) {
    const known = { channel };
    if (channel.encoding === "cdr") {
      if (channel.schemaEncoding !== "omgidl") fail(`${channel.topic}: schema encoding ${channel.schemaEncoding}`);
      const definitions = parseIDL(channel.schema);
      known.reader = new MessageReader(channel.schemaName, definitions);
      known.writer = new MessageWriter(channel.schemaName, definitions);
    } else {
      if (channel.schemaEncoding !== "jsonschema") fail(`${channel.topic}: schema encoding ${channel.schemaEncoding}`);
      known.schema = JSON.parse(channel.schema);
    }
    channels.set(client.subscribe(channel.id), known);
  }
  console.log("subscribed");
  const asking = client.advertise({ topic: "operator/request", encoding: "json", schemaName: "tonus.OperatorRequest" });
  const request = { request_id: "0123456789abcdef0123456789abcdef", request: "unknown thing" };
  client.sendMessage(asking, new TextEncoder().encode(JSON.stringify(request)));
});
client.on("message", ({ subscriptionId, data }) => {
  const known = channels.get(subscriptionId);
  const { topic, encoding } = known.channel;
  if (encoding === "json") {
    const message = JSON.parse(new TextDecoder().decode(data));
    checkJson(topic, known.schema, message);
    if (topic === "operator/reply" && message.is_done !== false) fail("an unknown request was not refused");
    missing.delete(topic);
  } else if (expected[topic]) {
    check(topic, known, data);
  }
  finishIfDone();
});
if (mode !== "--watch") {
  setTimeout(() => {
    fail(`nothing has come on: ${[...missing].join(", ")}`);
    process.exit(1);
  }, 50000);
}
