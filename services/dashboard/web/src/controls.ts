// The operator's buttons. They stay where they are: one that cannot be pressed says why below its name, keeps the focus,
// and repeats the reason when it is pressed.

import { reasonsAgainst, type Action, type Control, type DeskView } from "./desk_state";
import { el, setText } from "./dom";

const AGAIN_MS = 4000;

export interface ControlActions {
  ask: (request: string) => void;
  say: (text: string, isBad?: boolean) => void;
}

interface Entry {
  control: Exclude<Control, "start">;
  name: string;
  key: string; // of Alt+key, by its place on the keyboard
  request: string;
  /// Said where a second press is needed.
  warning?: string;
}

const entries: readonly Entry[] = [
  { control: "resume", name: "Resume", key: "R", request: "resume" },
  { control: "pause", name: "Pause", key: "P", request: "pause" },
  { control: "clear-fault", name: "Clear fault", key: "F", request: "clear_fault" },
  { control: "abort-trial", name: "Abort trial", key: "T", request: "abort_trial" },
  { control: "abort", name: "Abort session", key: "A", request: "abort", warning: "Abort session ends this session for good." },
];

/// Sets whether a button can be pressed without taking the focus from it.
export function setReason(button: HTMLElement, why: HTMLElement, reason: string): void {
  const is = reason === "" ? "false" : "true";
  if (button.getAttribute("aria-disabled") !== is) button.setAttribute("aria-disabled", is);
  setText(why, reason);
}

export class Controls {
  readonly root = el("div", { class: "controls", role: "group", "aria-label": "Controls of the session" });
  #buttons = new Map<Control, { button: HTMLButtonElement; why: HTMLElement }>();
  #actions: ControlActions;
  #reasons?: Record<Control, string>;
  #armed = { control: "", at: -Infinity };

  constructor(actions: ControlActions) {
    this.#actions = actions;
    for (const entry of entries) {
      const why = el("small", { id: `${entry.control}-why` });
      const button = el(
        "button",
        { id: entry.control, type: "button", title: `${entry.name} (Alt+${entry.key})`, "aria-keyshortcuts": `Alt+${entry.key}`, "aria-disabled": "true", "aria-describedby": why.id },
        el("span", {}, entry.name),
        why,
      );
      button.addEventListener("click", () => this.#press(entry));
      this.#buttons.set(entry.control, { button, why });
      this.root.append(button);
    }
    document.addEventListener("keydown", (event) => {
      if (!event.altKey || event.ctrlKey || event.repeat) return;
      const entry = entries.find(({ key }) => event.code === `Key${key}`);
      if (!entry) return;
      event.preventDefault();
      this.#press(entry);
    });
  }

  show(view: DeskView, next: Action): void {
    this.#reasons = reasonsAgainst(view);
    for (const [control, { button, why }] of this.#buttons) {
      setReason(button, why, this.#reasons[control]);
      button.classList.toggle("main", control === next && this.#reasons[control] === "");
    }
  }

  #press({ control, name, request, warning }: Entry): void {
    const reason = this.#reasons?.[control] ?? "not connected";
    if (reason) return this.#actions.say(`${name} is not possible now: ${reason}.`, true);
    const isSecond = this.#armed.control === control && performance.now() - this.#armed.at < AGAIN_MS;
    if (warning && !isSecond) {
      this.#armed = { control, at: performance.now() };
      return this.#actions.say(`${warning} Press it again within ${AGAIN_MS / 1000} s.`, true);
    }
    this.#armed = { control: "", at: -Infinity };
    this.#actions.ask(request);
  }
}
