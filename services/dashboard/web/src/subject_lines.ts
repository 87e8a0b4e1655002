// The line that tells the subject what to do. It depends on the state of the session, never on that of a trial: nothing in
// it gives away when a push comes. English is here; public/languages has a file for each other language.

import { RigMode, SessionPhase } from "./contract";
import { isGone, type DeskView } from "./desk_state";
import { isActive } from "./names";

export const subjectLines = [
  "wait_for_operator", "preparing", "to_the_circle", "running", "rest", "stopped", "over", "disconnected", "connecting", "token",
] as const;
export type SubjectLine = (typeof subjectLines)[number];

/// One language's texts.
export type SubjectTexts = Record<SubjectLine, string> & { name: string };

export const english: SubjectTexts = {
  name: "English",
  wait_for_operator: "Please wait for the operator.",
  preparing: "The experiment is being prepared. Please wait.",
  to_the_circle: "Bring your hand to the circle.",
  running: "The experiment is running.",
  rest: "Pause. You can rest.",
  stopped: "Let go. The experiment has stopped.",
  over: "The experiment is over. Thank you.",
  disconnected: "Let go. The connection is lost. Please wait.",
  connecting: "Please wait.",
  token: "A token is needed: open this page as /subject#token=…",
};

export function subjectLineOf(view: DeskView): SubjectLine {
  switch (view.link) {
    case "refused":
      return "token";
    case "connecting":
      return "connecting";
    case "disconnected":
      return "disconnected";
    case "connected":
      return connectedLineOf(view);
  }
}

function connectedLineOf({ session, rig, rigSilence, schedulerSilence }: DeskView): SubjectLine {
  const isGoing = session !== undefined && isActive(session.phase);
  const isStopped = rig?.mode === RigMode.RIG_HELD || (isGoing && (isGone(rigSilence) || isGone(schedulerSilence)));
  if (isStopped) return "stopped";
  if (!session) return "wait_for_operator";
  switch (session.phase) {
    case SessionPhase.SESSION_RUNNING:
    case SessionPhase.SESSION_PAUSING: // the trial that runs is finished first: as if nothing had been pressed
      return "running";
    case SessionPhase.SESSION_PAUSED:
      return "rest";
    case SessionPhase.SESSION_WAITING:
      return session.waiting_for.startsWith("operator: bring the subject's hand") ? "to_the_circle" : "wait_for_operator";
    case SessionPhase.SESSION_PREPARING:
      return session.waiting_for.startsWith("operator: bring the subject's hand") ? "to_the_circle" : "preparing";
    case SessionPhase.SESSION_READY:
      return "preparing";
    case SessionPhase.SESSION_COMPLETING:
    case SessionPhase.SESSION_COMPLETED:
      return "over";
    case SessionPhase.SESSION_ABORTED:
    case SessionPhase.SESSION_FAILED:
      return "wait_for_operator";
  }
}

/// What is wrong with a language's file; empty where nothing is.
export function textsProblem(texts: unknown): string {
  if (typeof texts !== "object" || texts === null) return "expected one JSON object";
  const missing = ["name", ...subjectLines].filter((key) => typeof (texts as Record<string, unknown>)[key] !== "string");
  return missing.length > 0 ? `${missing.join(", ")}: missing` : "";
}
