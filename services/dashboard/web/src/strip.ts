// The state strip: one line in the same place of every page, with colour, icon and words.

import { stripOf, type Icon, type Strip } from "./desk_state";
import type { Desk } from "./desk";
import { el, setText, svg } from "./dom";

const REFRESH_MS = 250;

const paths: Record<Icon, string> = {
  run: "M 7 4 L 20 12 L 7 20 Z",
  hand: "M 12 2 L 23 21 H 1 Z M 11 9 h 2 v 6 h -2 Z M 11 16.5 h 2 v 2 h -2 Z",
  wait: "M 6 3 H 18 V 7 L 13.5 12 L 18 17 V 21 H 6 V 17 L 10.5 12 L 6 7 Z",
  stop: "M 8 2 H 16 L 22 8 V 16 L 16 22 H 8 L 2 16 V 8 Z M 7 10.5 H 17 V 13.5 H 7 Z",
  cross: "M 5 3 L 12 10 L 19 3 L 21 5 L 14 12 L 21 19 L 19 21 L 12 14 L 5 21 L 3 19 L 10 12 L 3 5 Z",
  tick: "M 3 13 L 6 10 L 10 14 L 19 4 L 22 7 L 10 20 Z",
  dot: "M 12 5 A 7 7 0 1 1 11.99 5 Z",
};

export function stateStrip(desk: Desk): HTMLElement {
  const shape = svg("path", { "fill-rule": "evenodd" });
  const head = el("strong", { id: "strip-head" });
  const text = el("span", { id: "strip-text" });
  // A screen reader hears changes of the state, not each second that goes by.
  const heard = el("span", { class: "unseen", role: "status", id: "strip-heard" });
  const icon = svg("svg", { viewBox: "0 0 24 24", "aria-hidden": "true", class: "icon" }, shape);
  const root = el("section", { class: "strip", id: "strip", "aria-label": "State of the experiment" }, icon, el("p", { tabindex: 0 }, head, " ", text), heard);
  const show = (strip: Strip): void => {
    shape.setAttribute("d", paths[strip.icon]);
    setText(head, strip.head);
    setText(text, strip.text);
    root.title = `${strip.head} ${strip.text}`;
    if (root.dataset["state"] === strip.key) return;
    root.dataset["state"] = strip.key;
    root.dataset["tone"] = strip.tone;
    setText(heard, `${strip.head} ${strip.text}`);
  };
  const refresh = (): void => show(stripOf(desk.view()));
  refresh();
  setInterval(refresh, REFRESH_MS);
  return root;
}
