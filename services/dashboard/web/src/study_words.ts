// What is said of a study: sessions done and due, who is next. Pure.

export interface StudySession {
  protocol: string;
  file?: string;
  session_id: string | null;
  state: string | null;
  counted: number;
  planned: number;
  is_pilot: boolean;
  is_done: boolean;
}

export interface StudySubject {
  subject: string;
  seed: number | null;
  done: number;
  due: number | null; // null: not known
  sessions: StudySession[];
  others: StudySession[];
}

export interface NextSession {
  subject: string;
  protocol: string;
  file: string;
  seed: number;
}

/// As the gateway's people_api.hpp gives them.
export interface Study {
  study: string;
  problem: string | null;
  subjects: StudySubject[];
  next: NextSession | null;
}

export function nextLine({ next, problem, subjects }: Study): string {
  if (problem) return `${problem.charAt(0).toUpperCase()}${problem.slice(1)}.`;
  if (!next) return subjects.length > 0 ? "Every session is done." : "It has no subjects.";
  return `Next: ${next.subject}, ${next.protocol}.`;
}

/// "3 of 14 sessions done, 2 of 11 subjects".
export function doneLine({ subjects }: Study): string {
  const done = subjects.reduce((sum, subject) => sum + subject.done, 0);
  if (subjects.some(({ due }) => due === null)) return `${done} sessions done`;
  const all = subjects.reduce((sum, subject) => sum + subject.done + subject.due!, 0);
  return `${done} of ${all} sessions done, ${subjects.filter(({ due }) => due === 0).length} of ${subjects.length} subjects`;
}

/// "unloaded: done", "loaded: aborted after 5 of 40", "loaded: due".
export function sessionWord({ protocol, state, is_done, is_pilot, session_id, counted, planned }: StudySession): string {
  const pilot = is_pilot ? ", pilot" : "";
  if (is_done) return `${protocol}: done${pilot}`;
  if (session_id === null) return `${protocol}: due`;
  return `${protocol}: ${state ?? "state not known"}${state === "completed" ? "" : ` after ${counted} of ${planned}`}${pilot}`;
}

/// Of the form that starts it.
export const startAddress = ({ study }: Study, { subject, file, seed }: NextSession): string =>
  `/#${new URLSearchParams({ subject, study, protocol: file, seed: String(seed) }).toString()}`;
