// Rules of the form that starts a session. Pure.

/// A study is many sessions, which `tonus` runs one after another.
export const isOfOneSession = ({ text }: { text: string }): boolean => !/^\s*kind\s*=\s*"study"/m.test(text);

/// Why an id is not one that BIDS allows; empty where it is: letters and digits, "sub-" before them or not.
export function subjectProblem(id: string): string {
  if (id.trim() === "") return "Subject: an id is needed, such as sub-01.";
  const label = id.startsWith("sub-") ? id.slice(4) : id;
  if (/^[A-Za-z0-9]+$/.test(label)) return "";
  return `Subject: "${id}" is not allowed; expected letters and digits, such as sub-01.`;
}

/// The subjects of past sessions, in the order of their ids.
export function knownSubjects(sessions: { subject: string }[]): { id: string; sessions: number }[] {
  const counts = new Map<string, number>();
  for (const { subject } of sessions) if (subject) counts.set(subject, (counts.get(subject) ?? 0) + 1);
  return [...counts]
    .map(([id, count]) => ({ id, sessions: count }))
    .sort((a, b) => a.id.localeCompare(b.id, "en", { numeric: true }));
}

/// A seed that nobody chose, short enough to be read aloud.
export const drawnSeed = (): number => 1 + (crypto.getRandomValues(new Uint32Array(1))[0]! % 999_999);

/// A session of the archive, as far as the form needs it; the newest comes first.
export interface KnownSession {
  session_id: string;
  subject: string;
}

/// The names that studies give themselves.
export const studyNames = (protocols: { text: string }[]): string[] =>
  protocols.filter((protocol) => !isOfOneSession(protocol)).flatMap(({ text }) => /^\s*name\s*=\s*"([^"]*)"/m.exec(text)?.[1] ?? []);
