// Holds a layout of Lichtblick or Foxglove against what a gateway offers: every topic is a channel, and every path
// leads through the fields of its schema to a value that the panel can show.
//
//   node read_layout.cjs PACKAGES URL LAYOUT.json

const { createRequire } = require("node:module");
const { readFileSync } = require("node:fs");

const [packages, url, file] = process.argv.slice(2);
const load = createRequire(`${packages}/package.json`);
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const { parseIDL } = load("@foxglove/omgidl-parser");
const WebSocket = load("ws");

const layout = JSON.parse(readFileSync(file, "utf8"));

/// "topic{key==value}.field[0].field": the topic, the fields that filters compare, and the way to the value.
function taken_apart(path) {
  const [, topic, rest] = path.match(/^([\w/]+)(.*)$/);
  const way = [...rest.matchAll(/\{(\w+)==("[^"]*"|\d+)\}|\.(\w+)|\[(\d+)\]/g)];
  if (way.map((part) => part[0]).join("") !== rest) throw new Error(`${path}: cannot be read`);
  return { topic, way };
}

const definition_of = (definitions, name) => definitions.find((one) => one.name === name);

/// The type where the path ends.
function follow({ way }, definitions, schemaName) {
  let at = { type: schemaName, isComplex: true };
  for (const [text, filter, , field, index] of way) {
    if (index !== undefined) {
      const length = at.arrayLengths?.[0] ?? at.arrayUpperBound ?? Infinity;
      if (!(at.isArray || at.arrayLengths) || Number(index) >= length) throw new Error(`${text}: ${at.name} has no such element`);
      at = { ...at, isArray: false, arrayLengths: undefined };
      continue;
    }
    const inner = definition_of(definitions, at.type)?.definitions.find((one) => one.name === (filter ?? field));
    if (!inner) throw new Error(`${text}: ${at.type} has no such field`);
    if (field !== undefined) at = inner;
  }
  return at;
}

function check(path, channels, mayBeWhole) {
  const parts = taken_apart(path);
  const channel = channels.find((one) => one.topic === parts.topic);
  if (!channel) throw new Error(`${path}: there is no such topic`);
  const end = follow(parts, parseIDL(channel.schema), channel.schemaName);
  const isNumber = !end.isArray && !end.arrayLengths && (!end.isComplex || end.enumType !== undefined);
  if (!mayBeWhole && !isNumber) throw new Error(`${path}: is no number`);
}

const client = new FoxgloveClient({
  ws: new WebSocket(url.replace("http", "ws"), [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
client.on("error", (error) => {
  console.error(`connection: ${error}`);
  process.exit(1);
});
client.on("advertise", (channels) => {
  let checked = 0;
  for (const config of Object.values(layout.configById)) {
    for (const { value } of config.paths ?? []) checked += check(value, channels, false) ?? 1;
    if (config.topicPath) checked += check(config.topicPath, channels, true) ?? 1;
  }
  console.log(`${checked} paths`);
  process.exit(checked > 0 ? 0 : 1);
});
