// How far an export or a report is, in words. Pure.

/// As the gateway's jobs.hpp gives them.
export interface Job {
  number: number;
  what: "export" | "report";
  subject: string;
  state: "waiting" | "running" | "done" | "failed";
  done: number;
  total: number;
  message: string;
  path: string;
}

export function jobLine({ what, subject, state, done, total, message }: Job): string {
  const head = `${what === "export" ? "Export" : "Report"} ${subject}: `;
  switch (state) {
    case "waiting":
      return `${head}waits for the one before it`;
    case "running":
      return head + (total > 0 ? `${done} of ${total}` : "begun");
    case "done":
      return `${head}done`;
    case "failed":
      return `${head}failed: ${message}`;
  }
}
