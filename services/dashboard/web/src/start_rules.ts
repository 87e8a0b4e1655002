// Rules of the form that starts a session. Pure.

import type { Facts } from "./subject_facts";

/// A study is many sessions, which `tonus` runs one after another.
export const isOfOneSession = ({ text }: { text: string }): boolean => !/^\s*kind\s*=\s*"study"/m.test(text);

/// Why an id is not one that BIDS allows; empty where it is: letters and digits, "sub-" before them or not.
export function subjectProblem(id: string): string {
  if (id.trim() === "") return "Subject: an id is needed, such as sub-01.";
  const label = id.startsWith("sub-") ? id.slice(4) : id;
  if (/^[A-Za-z0-9]+$/.test(label)) return "";
  return `Subject: "${id}" is not allowed; expected letters and digits, such as sub-01.`;
}

/// A subject of the archive, as the gateway lists them.
export interface KnownSubject {
  subject: string;
  sessions: number;
  pilot_sessions: number;
  subject_facts: Facts;
}

/// "sub-07 (2 sessions, 1 pilot)".
export function subjectText({ subject, sessions, pilot_sessions }: KnownSubject): string {
  const pilots = pilot_sessions > 0 ? `, ${pilot_sessions} pilot` : "";
  return `${subject} (${sessions} ${sessions === 1 ? "session" : "sessions"}${pilots})`;
}

/// A seed that nobody chose, short enough to be read aloud.
export const drawnSeed = (): number => 1 + (crypto.getRandomValues(new Uint32Array(1))[0]! % 999_999);

/// The names that studies give themselves.
export const studyNames = (protocols: { text: string }[]): string[] =>
  protocols.filter((protocol) => !isOfOneSession(protocol)).flatMap(({ text }) => /^\s*name\s*=\s*"([^"]*)"/m.exec(text)?.[1] ?? []);
