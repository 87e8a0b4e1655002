// A protocol as fields of a form: from the document to texts and back, and to TOML. What keys there are, and what may stand
// there, is the checker's; here is only how it is entered. Pure.

export type Value = string | number | boolean | Value[] | { [key: string]: Value };
export type Table = { [key: string]: Value };

/// As the gateway gives them: "bias.force_N", "posture[].name".
export interface ProtocolKey {
  name: string;
  expected: string;
  preset: string;
  is_needed: boolean;
  unit: string;
}

export type Widget = "flag" | "choice" | "choices" | "numbers" | "text" | "number";

/// How a value is entered, by what the checker expects.
export function widgetOf({ expected }: ProtocolKey): Widget {
  if (expected === "true or false") return "flag";
  if (expected.startsWith("one of ")) return "choice";
  if (expected.startsWith("a list, each one of ")) return "choices";
  if (expected.startsWith("[")) return "numbers";
  return expected.startsWith("text of ") ? "text" : "number";
}

export const choicesOf = ({ expected }: ProtocolKey): string[] => expected.replace(/^(a list, each )?one of /, "").split(", ");

/// The value of what was entered; undefined where nothing was: the key is left out. What is no number stays a text, and the
/// checker says so.
export function valueOf(entered: string, widget: Widget): Value | undefined {
  const text = entered.trim();
  if (text === "") return undefined;
  const number = (part: string): Value => (part !== "" && Number.isFinite(Number(part)) ? Number(part) : part);
  const parts = text.replace(/^\[|\]$/g, "").split(",").map((part) => part.trim()).filter((part) => part !== "");
  switch (widget) {
    case "flag":
      return text === "true";
    case "choice":
    case "text":
      return text;
    case "choices":
      return parts;
    case "numbers":
      return parts.length === 1 ? number(parts[0]!) : parts.map(number);
    case "number":
      return number(text);
  }
}

/// What a field shows of a value.
export function enteredText(value: Value | undefined): string {
  if (value === undefined) return "";
  return Array.isArray(value) ? value.map(String).join(", ") : typeof value === "object" ? "" : String(value);
}

/// The parts of a key's name: the list in whose tables its own table is, that table, whether it is a list of tables, and key.
export function placeOf(name: string): { parent: string; table: string; isList: boolean; key: string } {
  const dot = name.lastIndexOf(".");
  const path = dot < 0 ? "" : name.slice(0, dot);
  const nested = path.lastIndexOf("[].");
  const table = nested < 0 ? path : path.slice(nested + 3);
  return { parent: nested < 0 ? "" : path.slice(0, nested), table: table.replace(/\[\]$/, ""), isList: path.endsWith("[]"), key: name.slice(dot + 1) };
}

/// A text of the document; empty where there is none.
export const textIn = (document: Table, key: string): string => (typeof document[key] === "string" ? document[key] : "");

/// The tables of a list in the document; none where it is not there.
export const listIn = (document: Table, name: string): Table[] => (Array.isArray(document[name]) ? (document[name] as Table[]) : []);

const isTable = (value: Value): value is Table => typeof value === "object" && !Array.isArray(value);
const isListOfTables = (value: Value): value is Table[] => Array.isArray(value) && value.length > 0 && value.every(isTable);

/// TOML: keys first, then tables, then lists of tables, each in the order of the document.
export function tomlOf(document: Table): string {
  const lines = keysOf(document);
  for (const [name, value] of Object.entries(document)) if (isTable(value)) lines.push("", `[${name}]`, ...keysOf(value));
  return [...lines, ...listsOf(document, "")].join("\n") + "\n";
}

/// The lists of tables in a table, each with those in its own tables.
const listsOf = (table: Table, path: string): string[] =>
  Object.entries(table).flatMap(([name, value]) =>
    isListOfTables(value) ? value.flatMap((one) => ["", `[[${path}${name}]]`, ...keysOf(one), ...listsOf(one, `${path}${name}.`)]) : [],
  );

const keysOf = (table: Table): string[] =>
  Object.entries(table).flatMap(([key, value]) => (isTable(value) || isListOfTables(value) ? [] : [`${key} = ${literal(value)}`]));

function literal(value: Value): string {
  if (Array.isArray(value)) return `[${value.map(literal).join(", ")}]`;
  if (typeof value === "object") return `{ ${Object.entries(value).map(([key, one]) => `${key} = ${literal(one)}`).join(", ")} }`;
  // Of JSON's escapes all are TOML's; DEL is the one character that TOML wants escaped and JSON does not.
  return typeof value === "string" ? JSON.stringify(value).replaceAll("\u007f", "\\u007F") : String(value);
}
