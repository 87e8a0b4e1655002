// Twenty clients of a gateway that subscribe to every channel, in a process of their own; they count what comes, two of
// them read nothing at all. Their own work belongs to other machines: they run at the lowest priority. "on" and "off" on standard input.

const { createRequire } = require("node:module");
const { createInterface } = require("node:readline");

const [packages, url] = process.argv.slice(2);
const load = createRequire(`${packages}/package.json`);
const WebSocket = load("ws");
const CLIENTS = 20;
const DEAF = 2;

let sockets = [];
let messages = 0;
let bytes = 0;

function connect(isDeaf) {
  const socket = new WebSocket(url, ["foxglove.websocket.v1"], { perMessageDeflate: false });
  socket.on("message", (data, isBinary) => {
    messages += 1;
    bytes += data.length;
    if (isBinary) return;
    const { op, channels } = JSON.parse(data);
    if (op !== "advertise") return;
    const subscriptions = channels.map(({ id }) => ({ id, channelId: id }));
    socket.send(JSON.stringify({ op: "subscribe", subscriptions }));
    if (isDeaf) socket.pause();
  });
  socket.on("error", () => undefined);
  return socket;
}

createInterface({ input: process.stdin }).on("line", (line) => {
  if (line === "on") sockets = Array.from({ length: CLIENTS }, (_, i) => connect(i < DEAF));
  for (const socket of line === "off" ? sockets : []) socket.terminate();
  console.log(JSON.stringify({ messages, bytes }));
});
