// The results of one session, live or from the archive.

import { EstimateStatus, type Estimate, type SessionPlan } from "./contract";
import { armChart, convergenceChart, curlChart, methodChart, springChart } from "./charts";
import { el, panel, setText } from "./dom";
import { EllipseChart } from "./ellipses";
import {
  conditionOf,
  elementNames,
  inOrder,
  matrixNames,
  matrixTitles,
  methodOf,
  toneClass,
  unitOf,
  isWhole,
  type MatrixName,
} from "./matrices";
import { ellipseRows, ellipseTable, progressList } from "./ellipse_table";
import { noFacts, type SessionFacts } from "./estimates_text";
import { hex } from "./names";
import { colourOf, keyOf, postureTones } from "./posture_style";
import { ResultsTable, type TableActions } from "./results_table";

export const USUAL_METHOD = "state_variable";

export class ResultsView {
  readonly root = el("div", { class: "results" });
  readonly age: HTMLElement;
  #newest = new Map<string, Estimate>();
  #history = new Map<string, Estimate[]>();
  #method = el("select", { id: "method" });
  #condition = el("select", { id: "condition" });
  #matrix = el("select", { id: "matrix" }, ...matrixNames.map((name) => el("option", { value: name }, matrixTitles[name])));
  #ellipses = matrixNames.map((name) => new EllipseChart(name));
  #charts = { convergence: el("div"), curl: el("div"), methods: el("div"), springs: el("div"), arm: el("div") };
  #legends = { postures: el("ul", { class: "legend" }), springs: el("ul", { class: "legend" }), methods: el("ul", { class: "legend" }), elements: el("ul", { class: "legend" }) };
  #captions = { ellipses: el("p", { class: "caption" }), convergence: el("p", { class: "caption" }), curl: el("p", { class: "caption" }), methods: el("p", { class: "caption" }), springs: el("p", { class: "caption" }), arm: el("p", { class: "caption" }), numbers: el("p", { class: "caption" }) };
  #progress = el("ul", { class: "progress", id: "posture-progress", tabindex: 0, "aria-label": "How well each posture is known" });
  #numbers = el("tbody", { id: "ellipse-numbers" });
  #table: ResultsTable;
  #facts: SessionFacts = noFacts;
  #planned: ReadonlyMap<string, number> = new Map();
  #isDue = false;

  constructor(actions: TableActions) {
    this.#table = new ResultsTable(actions);
    this.#matrix.value = "K";
    for (const select of [this.#method, this.#condition, this.#matrix])
      select.addEventListener("change", () => this.#render());
    const choose = el(
      "div",
      { class: "row" },
      el("label", {}, "Method", this.#method),
      el("label", {}, "Condition", this.#condition),
      el("label", {}, "Matrix", this.#matrix),
    );
    const ellipses = panel(
      "Ellipses, with 95 % intervals",
      "ellipses",
      this.#captions.ellipses,
      this.#progress,
      el("div", { class: "columns three" }, ...this.#ellipses.map((chart) => chart.root)),
      this.#legends.postures,
    );
    this.age = ellipses.age;
    const table = panel("Estimates, ± standard error", "table", this.#table.root);
    const matrixLegend = legend(el("ul", { class: "legend" }), matrixNames);
    this.root.append(
      choose,
      ellipses.root,
      el(
        "div",
        { class: "columns small" },
        panel("Arm from above", "arm", this.#captions.arm, this.#charts.arm).root,
        panel("Convergence", "convergence", this.#captions.convergence, this.#charts.convergence, this.#legends.elements).root,
        panel("Curl", "curl", this.#captions.curl, this.#charts.curl, matrixLegend).root,
        panel("Methods", "methods", this.#captions.methods, this.#charts.methods, this.#legends.methods).root,
        panel("Spring centres", "springs", this.#captions.springs, this.#charts.springs, this.#legends.springs).root,
      ),
      panel("Size, shape, orientation, curl", "numbers", this.#captions.numbers, ellipseTable(this.#numbers)).root,
      table.root,
    );
    this.#render();
  }

  clear(): void {
    this.#newest.clear();
    this.#history.clear();
    this.#renderSoon();
  }

  /// In the order of publication. An estimate of fewer trials than one that is there is older, and is history.
  add(estimate: Estimate): void {
    const id = hex(estimate.estimate_id);
    const known = this.#newest.get(id);
    if (!known || estimate.trials_used + estimate.trials_rejected >= known.trials_used + known.trials_rejected)
      this.#newest.set(id, estimate);
    if (!isDetermined(estimate)) return this.#renderSoon(); // has no values
    const history = this.#history.get(id) ?? [];
    const same = history.findIndex((other) => other.trials_used === estimate.trials_used);
    if (same >= 0) history[same] = estimate;
    else history.push(estimate);
    history.sort((a, b) => a.trials_used - b.trials_used);
    this.#history.set(id, history);
    this.#renderSoon();
  }

  /// Of the session that is shown; undefined where it is not known.
  setPlan(plan: SessionPlan | undefined): void {
    this.#facts = plan
      ? { subject: plan.subject, protocol: plan.protocol_name, seed: String(plan.seed), started_at: plan.started_at, software_version: plan.software_version, operator: plan.operator_name, study: plan.study, is_pilot: plan.is_pilot ? "yes" : "no" }
      : noFacts;
    this.#planned = new Map(plan?.postures.map(({ name, trials }) => [name, trials]));
    this.#renderSoon();
  }

  get count(): number {
    return this.#newest.size;
  }

  #renderSoon(): void {
    if (this.#isDue) return;
    this.#isDue = true;
    setTimeout(() => {
      this.#isDue = false;
      this.#render();
    }, 150);
  }

  #render(): void {
    const all = [...this.#newest.values()].sort(inOrder);
    keepChoices(this.#method, unique(all.map(methodOf)), USUAL_METHOD);
    keepChoices(this.#condition, unique(all.map(conditionOf)));
    const ofMethod = all.filter((estimate) => methodOf(estimate) === this.#method.value);
    const ofCondition = all.filter((estimate) => conditionOf(estimate) === this.#condition.value);
    const matrix = this.#matrix.value as MatrixName;
    const chosen = ofCondition.find((estimate) => methodOf(estimate) === this.#method.value);
    const history = chosen ? (this.#history.get(hex(chosen.estimate_id)) ?? []) : [];
    for (const chart of this.#ellipses) chart.update(ofMethod, this.#condition.value, this.#planned);
    this.#charts.arm.replaceChildren(armChart(ofMethod, matrix));
    this.#charts.convergence.replaceChildren(convergenceChart(history, matrix));
    this.#charts.curl.replaceChildren(curlChart(ofMethod.filter(isDetermined)));
    this.#charts.methods.replaceChildren(methodChart(ofCondition.filter(isDetermined), matrix));
    this.#charts.springs.replaceChildren(springChart(ofMethod.filter(isDetermined)));
    this.#numbers.replaceChildren(...ellipseRows(ofMethod));
    const places = postureTones(ofMethod);
    postureLegend(this.#legends.postures, places);
    postureLegend(this.#legends.springs, places);
    this.#progress.replaceChildren(...progressList(ofMethod.filter(isWhole), matrix, this.#planned, places));
    legend(this.#legends.methods, ofCondition.filter(isDetermined).map(methodOf));
    legend(this.#legends.elements, elementNames.map((name) => `${matrix}${name}`));
    this.#caption(all, matrix);
    this.#table.update(all, this.#facts);
  }

  /// Each drawing says what it is of: condition, matrix, method, unit.
  #caption(all: Estimate[], matrix: MatrixName): void {
    const method = this.#method.value;
    const condition = this.#condition.value;
    const first = all[0];
    const unit = first ? unitOf(first, matrix) : "";
    const say = (element: HTMLElement, ...parts: string[]): void => setText(element, first ? parts.filter((part) => part !== "").join(", ") : "");
    say(this.#captions.ellipses, `method ${method}`, "restoring force for unit displacement in each direction");
    say(this.#captions.arm, "all postures", `${matrixTitles[matrix]} in ${unit}`, `method ${method}`);
    say(this.#captions.convergence, condition, `${matrixTitles[matrix]} in ${unit}`, `method ${method}`);
    say(this.#captions.curl, "all conditions", `method ${method}`, "without unit");
    say(this.#captions.methods, condition, `${matrixTitles[matrix]} in ${unit}`);
    say(this.#captions.springs, "all conditions", `method ${method}`, "from the posture, in mm");
    say(this.#captions.numbers, `method ${method}`, "size in the matrix's unit squared", "[low, high] of the 95 % interval");
  }
}

export function legend(list: HTMLElement, names: string[]): HTMLElement {
  list.replaceChildren(...names.map((name, i) => el("li", { class: toneClass(i) }, name)));
  return list;
}

/// What is not determined has no values to draw: not known is not zero.
const isDetermined = (estimate: Estimate): boolean => estimate.status !== EstimateStatus.ESTIMATE_UNDETERMINED;

function postureLegend(list: HTMLElement, places: ReadonlyMap<string, number>): void {
  list.classList.add("postures");
  list.replaceChildren(...[...places].map(([name, place]) => el("li", { class: toneClass(colourOf(place)) }, keyOf(place), name)));
}

export const unique = (names: string[]): string[] => [...new Set(names)];

export function keepChoices(select: HTMLSelectElement, names: string[], usual = ""): void {
  if (names.join("\n") === Array.from(select.options, (option) => option.value).join("\n")) return;
  const chosen = select.value || usual;
  select.replaceChildren(...names.map((name) => el("option", { value: name }, name)));
  if (names.includes(chosen)) select.value = chosen;
}
