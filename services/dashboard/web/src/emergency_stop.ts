// The button that is on every page, for viewers too: takes the rig's torque away. Ctrl+Space presses it.

import type { Connection } from "./connection";
import { el } from "./dom";

export function emergencyStop(
  connection: Connection,
  text: string,
  say: (text: string, isBad?: boolean) => void,
): HTMLButtonElement {
  const stop = el(
    "button",
    {
      class: "stop",
      id: "emergency-stop",
      type: "button",
      title: "Takes the rig's torque away at once (Ctrl+Space)",
      "aria-label": "Emergency stop",
      "aria-keyshortcuts": "Control+Space",
    },
    text,
  );
  stop.addEventListener("click", () => {
    if (connection.state !== "connected") {
      say("Emergency stop NOT sent: disconnected. Use the button at the rig.", true);
      return;
    }
    say("Emergency stop is being sent…", true);
    void connection.request("emergency_stop").then((reply) => {
      say(`Emergency stop ${reply.is_done ? "done" : "FAILED"}: ${reply.message}`, true);
    });
  });
  document.addEventListener("keydown", (event) => {
    if (!event.ctrlKey || event.code !== "Space") return;
    event.preventDefault();
    if (!event.repeat) stop.click();
  });
  return stop;
}
