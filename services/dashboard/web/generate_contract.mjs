// Writes contract.ts, the TypeScript types and enumerations of idl/*.idl, as omgidl-serialization decodes them.
//
//   node generate_contract.mjs PACKAGES IDL_FOLDER OUT.ts            writes the file
//   node generate_contract.mjs PACKAGES IDL_FOLDER OUT.ts --check    fails where the file is not what would be written
//
// PACKAGES is the folder of package.json beside node_modules.

import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const [packages, idlFolder, out, mode] = process.argv.slice(2);
const { parseIDL } = createRequire(resolve(packages, "package.json"))("@foxglove/omgidl-parser");

const primitives = {
  bool: "boolean", string: "string", float32: "number", float64: "number", uint8: "number", int8: "number",
  uint16: "number", int16: "number", uint32: "number", int32: "number", int64: "bigint", uint64: "bigint",
};
// The reader returns sequences and arrays of numbers, enumerations among them, as typed arrays.
const typedArrays = {
  float64: "Float64Array", float32: "Float32Array", uint8: "Uint8Array", int8: "Int8Array", uint16: "Uint16Array",
  int16: "Int16Array", uint32: "Uint32Array", int32: "Int32Array", int64: "BigInt64Array", uint64: "BigUint64Array",
};

const lastName = (name) => name.slice(name.lastIndexOf("::") + 2);

function elementType(field) {
  if (field.enumType !== undefined) return lastName(field.enumType);
  if (field.isComplex) return lastName(field.type);
  const type = primitives[field.type];
  if (type === undefined) throw new Error(`${field.name}: type ${field.type} is not supported; extend ${import.meta.url}`);
  return type;
}

function typeOf(field) {
  const isArray = field.isArray || field.arrayLengths !== undefined;
  if (!isArray) return elementType(field);
  return (!field.isComplex && typedArrays[field.type]) || `${elementType(field)}[]`;
}

const structText = ({ name, definitions }) =>
  [`export interface ${lastName(name)} {`, ...definitions.map((field) => `  ${field.name}: ${typeOf(field)};`), "}"].join("\n");

// Constants, because Node.js runs the tests' TypeScript without the compiler's own enumerations.
function enumText({ name, definitions }) {
  // The parser gives a file's own constants as a module named after the contract's version.
  const short = name.endsWith("::v1") ? "Constants" : lastName(name);
  return [
    `export const ${short} = {`,
    ...definitions.map((constant) => `  ${constant.name}: ${constant.value},`),
    "} as const;",
    `export type ${short} = (typeof ${short})[keyof typeof ${short}];`,
  ].join("\n");
}

const files = readdirSync(idlFolder).filter((name) => name.endsWith(".idl")).sort();
const parts = files.flatMap((file) =>
  parseIDL(readFileSync(join(idlFolder, file), "utf8")).map((definition) => {
    if (definition.aggregatedKind === "struct") return structText(definition);
    if (definition.aggregatedKind === "module" && definition.definitions.every((one) => one.isConstant)) return enumText(definition);
    throw new Error(`${file}: ${definition.name} is a ${definition.aggregatedKind}; extend ${import.meta.url}`);
  }),
);
const text = [
  "// Generated from idl/*.idl by generate_contract.mjs; do not edit. 64-bit integers are bigint; units are in the names.",
  ...parts,
].join("\n\n") + "\n";

if (mode !== "--check") {
  writeFileSync(out, text);
} else if (readFileSync(out, "utf8") !== text) {
  console.error(`${out}: differs from ${idlFolder}; run node generate_contract.mjs ${packages} ${idlFolder} ${out}`);
  process.exit(1);
}
