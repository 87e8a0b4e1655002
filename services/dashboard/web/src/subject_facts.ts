// What is known of a subject, as fields of a form: lengths in cm as people measure them, in m on the wire. Pure.

import type { SubjectFacts } from "./contract";

/// As the gateway takes and gives them; null and "" are not known.
export type Facts = Record<string, number | string | null | (number | null)[]>;

interface Field {
  id: string;
  name: string;
  key: keyof SubjectFacts;
  /// Of a pair.
  part?: 0 | 1;
  /// Of a text.
  choices?: readonly string[];
  /// From what is entered to what is sent.
  scale?: number;
}

export const subjectFields: readonly Field[] = [
  { id: "age", name: "Age (years)", key: "age_years" },
  { id: "sex", name: "Sex", key: "sex", choices: ["female", "male", "other"] },
  { id: "handedness", name: "Handedness", key: "handedness", choices: ["right", "left", "ambidextrous"] },
  { id: "measured-arm", name: "Measured arm", key: "measured_arm", choices: ["right", "left"] },
  { id: "height", name: "Height (cm)", key: "height_m", scale: 0.01 },
  { id: "weight", name: "Weight (kg)", key: "weight_kg" },
  { id: "upper-arm", name: "Upper arm (cm)", key: "link_lengths_m", part: 0, scale: 0.01 },
  { id: "forearm", name: "Forearm to handle (cm)", key: "link_lengths_m", part: 1, scale: 0.01 },
  { id: "upper-girth", name: "Upper arm, girth (cm)", key: "circumferences_m", part: 0, scale: 0.01 },
  { id: "fore-girth", name: "Forearm, girth (cm)", key: "circumferences_m", part: 1, scale: 0.01 },
  { id: "shoulder-x", name: "Shoulder x (cm)", key: "shoulder_m", part: 0, scale: 0.01 },
  { id: "shoulder-y", name: "Shoulder y (cm)", key: "shoulder_m", part: 1, scale: 0.01 },
];

const DECIMALS = 6; // of what is sent: what 12.3 cm is in binary is not sent in full

/// What is entered, by the fields' ids; nothing entered is not known. The problem names the first field that has no number.
export function factsOf(entered: Readonly<Record<string, string>>): { facts: Facts; problem: string } {
  const facts: Facts = {};
  let problem = "";
  for (const { id, name, key, part, choices, scale } of subjectFields) {
    const text = (entered[id] ?? "").trim();
    if (choices) {
      facts[key] = text;
      continue;
    }
    const number = text === "" ? null : Number(text.replace(",", "."));
    if (number !== null && !Number.isFinite(number)) problem ||= `${name}: "${text}" is not allowed; expected a number.`;
    const value = number === null || !Number.isFinite(number) ? null : Number((number * (scale ?? 1)).toFixed(DECIMALS));
    if (part === undefined) facts[key] = value;
    else facts[key] = part === 0 ? [value, null] : [(facts[key] as (number | null)[])[0]!, value];
  }
  return { facts, problem };
}

/// What the fields show of facts.
export function enteredOf(facts: Facts): Record<string, string> {
  return Object.fromEntries(
    subjectFields.map(({ id, key, part, scale }) => {
      const found = facts[key];
      const value = Array.isArray(found) ? (found[part ?? 0] ?? null) : (found ?? null);
      if (value === null || value === "") return [id, ""];
      return [id, typeof value === "string" ? value : String(Number((value / (scale ?? 1)).toFixed(4)))];
    }),
  );
}
