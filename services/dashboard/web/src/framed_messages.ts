// Archived messages, as the gateway sends them: each preceded by its length, 32 bits, little-endian.

import { get } from "./access";
import { parse } from "./schemas";

export async function archivedMessages<T>(path: string, typeName: string, schema: string): Promise<T[]> {
  const data = new DataView(await (await get(path)).arrayBuffer());
  const reader = parse(typeName, schema);
  const messages: T[] = [];
  for (let at = 0; at + 4 <= data.byteLength; ) {
    const size = data.getUint32(at, true);
    messages.push(reader.readMessage<T>(new DataView(data.buffer, at + 4, size)));
    at += 4 + size;
  }
  return messages;
}
