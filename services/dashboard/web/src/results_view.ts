// The results of one session, live or from the archive.

import { EstimateStatus, type Estimate } from "./contract";
import { convergenceChart, curlChart, methodChart, springChart } from "./charts";
import { el, panel } from "./dom";
import { EllipseChart } from "./ellipses";
import {
  conditionOf,
  elementNames,
  inOrder,
  matrixNames,
  matrixTitles,
  methodOf,
  postureTones,
  toneClass,
  type MatrixName,
} from "./matrices";
import { hex } from "./names";
import { ResultsTable, type TableActions } from "./results_table";

const USUAL_METHOD = "state_variable";

export class ResultsView {
  readonly root = el("div", { class: "results" });
  readonly age: HTMLElement;
  #newest = new Map<string, Estimate>();
  #history = new Map<string, Estimate[]>();
  #method = el("select", { id: "method" });
  #condition = el("select", { id: "condition" });
  #matrix = el("select", { id: "matrix" }, ...matrixNames.map((name) => el("option", { value: name }, matrixTitles[name])));
  #ellipses = matrixNames.map((name) => new EllipseChart(name));
  #charts = { convergence: el("div"), curl: el("div"), methods: el("div"), springs: el("div") };
  #legends = { postures: el("ul", { class: "legend" }), springs: el("ul", { class: "legend" }), methods: el("ul", { class: "legend" }), elements: el("ul", { class: "legend" }) };
  #table: ResultsTable;
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
        panel("Convergence", "convergence", this.#charts.convergence, this.#legends.elements).root,
        panel("Curl", "curl", this.#charts.curl, matrixLegend).root,
        panel("Methods", "methods", this.#charts.methods, this.#legends.methods).root,
        panel("Spring centres", "springs", this.#charts.springs, this.#legends.springs).root,
      ),
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
    if (estimate.status === EstimateStatus.ESTIMATE_UNDETERMINED) return this.#renderSoon(); // has no values
    const history = this.#history.get(id) ?? [];
    const same = history.findIndex((other) => other.trials_used === estimate.trials_used);
    if (same >= 0) history[same] = estimate;
    else history.push(estimate);
    history.sort((a, b) => a.trials_used - b.trials_used);
    this.#history.set(id, history);
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
    for (const chart of this.#ellipses) chart.update(ofMethod, this.#condition.value);
    this.#charts.convergence.replaceChildren(convergenceChart(history, matrix));
    this.#charts.curl.replaceChildren(curlChart(ofMethod));
    this.#charts.methods.replaceChildren(methodChart(ofCondition, matrix));
    this.#charts.springs.replaceChildren(springChart(ofMethod));
    const postures = [...postureTones(ofMethod).keys()];
    legend(this.#legends.postures, postures);
    legend(this.#legends.springs, postures);
    legend(this.#legends.methods, ofCondition.map(methodOf));
    legend(this.#legends.elements, elementNames.map((name) => `${matrix}${name}`));
    this.#table.update(all);
  }
}

function legend(list: HTMLElement, names: string[]): HTMLElement {
  list.replaceChildren(...names.map((name, i) => el("li", { class: toneClass(i) }, name)));
  return list;
}

const unique = (names: string[]): string[] => [...new Set(names)];

function keepChoices(select: HTMLSelectElement, names: string[], usual = ""): void {
  if (names.join("\n") === Array.from(select.options, (option) => option.value).join("\n")) return;
  const chosen = select.value || usual;
  select.replaceChildren(...names.map((name) => el("option", { value: name }, name)));
  if (names.includes(chosen)) select.value = chosen;
}
