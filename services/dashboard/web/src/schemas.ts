import { parseIDL, type IDLMessageDefinition } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";

const parsed = new Map<string, IDLMessageDefinition[]>();

/// A reader for a type by the text that defines it; the text is parsed once.
export function parse(typeName: string, text: string): MessageReader {
  let definitions = parsed.get(text);
  if (!definitions) {
    definitions = parseIDL(text);
    parsed.set(text, definitions);
  }
  return new MessageReader(typeName, definitions);
}
