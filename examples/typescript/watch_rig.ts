// Prints the rig's mode with each of its reports, over tonus-dashboard and the Foxglove packages.
//
//   node watch_rig.cjs [ws://127.0.0.1:8765]

import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import { FoxgloveClient } from "@foxglove/ws-protocol";
import WebSocket from "ws";

interface RigState {
  mode: number;
  next_sequence: bigint;
}

const url = process.argv[2] ?? "ws://127.0.0.1:8765";
const client = new FoxgloveClient({ ws: new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]) });
let reader: MessageReader<RigState>;
let modes = new Map<number, string>(); // as the contract names them: RIG_IN_TRIAL, ...

client.on("advertise", (channels) => {
  const channel = channels.find(({ topic }) => topic === "rig/state")!;
  const definitions = parseIDL(channel.schema);
  reader = new MessageReader(channel.schemaName, definitions);
  const mode = definitions.find(({ name }) => name?.endsWith("::RigMode") ?? false);
  const named = (mode as { definitions?: { name: string; value: number }[] } | undefined)?.definitions ?? [];
  modes = new Map(named.map((one) => [Number(one.value), one.name]));
  client.subscribe(channel.id);
});
client.on("message", ({ data }) => {
  const state = reader.readMessage(data);
  console.log(`mode ${modes.get(state.mode) ?? state.mode}, ${state.next_sequence} samples`);
});
client.on("close", () => process.exit(1));
