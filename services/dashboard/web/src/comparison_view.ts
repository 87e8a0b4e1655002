// Two or more sessions beside each other: ellipses over each other, elements over time, differences from the session that is
// open.

import { differences, type Difference } from "./archive_lists";
import { sessionsChart } from "./charts";
import type { Estimate } from "./contract";
import { el, panel, setText } from "./dom";
import { EllipseChart } from "./ellipses";
import { conditionOf, elementNames, elementsOf, inOrder, isWhole, matrixNames, matrixTitles, methodOf, toneClass, unitOf, withError, type MatrixName } from "./matrices";
import { letterOf, overlaid, overTime, type ComparedSession } from "./overlay";
import { colourOf, keyOf } from "./posture_style";
import { keepChoices, legend, unique, USUAL_METHOD } from "./results_view";

export class ComparisonView {
  readonly root = el("div", { class: "results", id: "comparison" });
  readonly age: HTMLElement;
  #sessions: readonly ComparedSession[] = [];
  #method = el("select", { id: "compared-method" });
  #condition = el("select", { id: "compared-condition" });
  #matrix = el("select", { id: "compared-matrix" }, ...matrixNames.map((name) => el("option", { value: name }, matrixTitles[name])));
  #ellipses = matrixNames.map((name) => new EllipseChart(name));
  #names = el("ul", { class: "legend postures", id: "compared-sessions" });
  #caption = el("p", { class: "caption" });
  #time = el("div");
  #timeCaption = el("p", { class: "caption" });
  #elements = el("ul", { class: "legend" });
  #rows = el("tbody", { id: "differences" });

  constructor() {
    this.#matrix.value = "K";
    for (const select of [this.#method, this.#condition, this.#matrix]) select.addEventListener("change", () => this.#render());
    const choose = el("div", { class: "row" }, el("label", {}, "Method", this.#method), el("label", {}, "Condition", this.#condition), el("label", {}, "Matrix", this.#matrix));
    const ellipses = panel("Sessions compared", "overlay", this.#names, choose, this.#caption, el("div", { class: "columns three" }, ...this.#ellipses.map((chart) => chart.root)));
    this.age = ellipses.age;
    const heads = ["Session", "Condition", "Element", "Here (A)", "There", "Here - there", "Unit"].map((name) => el("th", { scope: "col" }, name));
    const table = el("table", {}, el("thead", {}, el("tr", {}, ...heads)), this.#rows);
    this.root.append(
      ellipses.root,
      el(
        "div",
        { class: "columns wide" },
        panel("Session by session", "over-time", this.#timeCaption, this.#time, this.#elements).root,
        panel("Difference, ± half of the 95 % interval", "difference", el("div", { class: "scroll", tabindex: 0, role: "group", "aria-label": "Differences" }, table)).root,
      ),
    );
    this.root.hidden = true;
  }

  /// The open session comes first; with it alone there is nothing to compare.
  show(sessions: readonly ComparedSession[]): void {
    this.#sessions = sessions;
    this.root.hidden = sessions.length < 2;
    if (!this.root.hidden) this.#render();
  }

  #render(): void {
    const all = this.#sessions.flatMap(({ estimates }) => estimates.filter(isWhole)).sort(inOrder);
    keepChoices(this.#method, unique(all.map(methodOf)), USUAL_METHOD);
    keepChoices(this.#condition, unique(all.map(conditionOf)));
    const [method, condition, matrix] = [this.#method.value, this.#condition.value, this.#matrix.value as MatrixName];
    this.#names.replaceChildren(
      ...this.#sessions.map(({ name }, i) => el("li", { class: toneClass(colourOf(i)) }, keyOf(i), `${letterOf(i)}: ${name}${i === 0 ? " (open)" : ""}`)),
    );
    const overlay = overlaid(this.#sessions, method);
    for (const chart of this.#ellipses) chart.update(overlay.estimates, "", new Map(), overlay.looks);
    const left = overlay.otherUnits > 0 ? `; ${overlay.otherUnits} estimates in other units are left out` : "";
    setText(this.#caption, `method ${method}, determined estimates of all sets, each posture where the first session measured it${left}`);
    this.#renderTime(method, condition, matrix);
    this.#renderDifferences(method);
  }

  #renderTime(method: string, condition: string, matrix: MatrixName): void {
    const course = overTime(this.#sessions, method, condition);
    this.#time.replaceChildren(sessionsChart(course, matrix));
    const first = course[0]?.estimate;
    setText(this.#timeCaption, first ? `${condition}, ${matrixTitles[matrix]} in ${unitOf(first, matrix)}, method ${method}, in the order of their start` : `no session has determined ${condition} by ${method}`);
    legend(this.#elements, first ? elementsOf(first).map((i) => `${matrix}${elementNames[i]!}`) : []);
  }

  #renderDifferences(method: string): void {
    const [here, ...others] = this.#sessions;
    const ofMethod = (estimates: readonly Estimate[]): Estimate[] => estimates.filter((estimate) => methodOf(estimate) === method);
    const rows = others.flatMap(({ estimates }, i) => differences(ofMethod(here!.estimates), ofMethod(estimates)).map((row) => differenceRow(row, letterOf(i + 1))));
    const none = el("tr", {}, el("td", { class: "faint", colspan: 7 }, `no condition that two sessions have determined by ${method}`));
    this.#rows.replaceChildren(...(rows.length > 0 ? rows : [none]));
  }
}

function differenceRow(row: Difference, letter: string): HTMLElement {
  const isApart = Math.abs(row.difference) > row.half95;
  return el(
    "tr",
    {},
    el("td", {}, letter),
    el("td", {}, row.condition),
    el("td", {}, `${row.matrix}${row.element}`),
    el("td", { class: "number" }, row.here.toPrecision(4)),
    el("td", { class: "number" }, row.other.toPrecision(4)),
    el("td", { class: "number", title: isApart ? "the interval does not hold zero" : "the interval holds zero" }, withError(row.difference, row.half95) + (isApart ? " *" : "")),
    el("td", {}, row.unit),
  );
}
