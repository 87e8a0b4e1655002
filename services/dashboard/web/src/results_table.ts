// All estimates as a table, to read, copy and download.

import { EstimateStatus, type Estimate } from "./contract";
import { el } from "./dom";
import { estimatesText, noFacts, type SessionFacts } from "./estimates_text";
import { conditionOf, elementNames, elementsOf, matrixNames, matrixOf, methodOf, unitOf, withError } from "./matrices";
import { hex, nameOf, statusNames } from "./names";

const statusTones: Record<EstimateStatus, string> = {
  [EstimateStatus.ESTIMATE_OK]: "good",
  [EstimateStatus.ESTIMATE_UNDETERMINED]: "faint",
  [EstimateStatus.ESTIMATE_SUSPECT]: "warn",
};

export interface TableActions {
  say: (text: string, isBad?: boolean) => void;
}

/// Lines, and a faint one below: the unit, say.
const stack = (className: string, lines: string[], last: string): HTMLElement =>
  el("td", { class: className }, ...lines.map((line) => el("div", {}, line)), el("div", { class: "faint" }, last));

export class ResultsTable {
  readonly root = el("div");
  #estimates: Estimate[] = [];
  #facts = noFacts;
  #body = el("tbody", { id: "estimates" });

  constructor({ say }: TableActions) {
    const copy = el("button", { type: "button", id: "copy" }, "Copy table");
    const download = el("button", { type: "button", id: "download" }, "Download CSV");
    copy.addEventListener("click", () => {
      navigator.clipboard.writeText(estimatesText(this.#estimates, "\t", this.#facts)).then(
        () => say(`Copied ${this.#estimates.length} estimates.`),
        (error: Error) => say(`Not copied: ${error.message}. Download works.`, true),
      );
    });
    download.addEventListener("click", () => this.#download());
    const head = el(
      "tr",
      {},
      ...["Condition, method", "Status"].map((name) => el("th", { scope: "col" }, name)),
      ...["Trials", "Rejected"].map((name) => el("th", { scope: "col", class: "number" }, name)),
      el("th", { scope: "col" }, "Element"),
      ...["M", "B", "K", "Spring centre", "Fit error σ"].map((name) => el("th", { scope: "col", class: "number" }, name)),
    );
    this.root.append(
      el("div", { class: "row" }, copy, download),
      el("div", { class: "scroll tall", tabindex: 0, role: "group", "aria-label": "Estimates" }, el("table", {}, el("thead", {}, head), this.#body)),
    );
  }

  update(estimates: Estimate[], facts: SessionFacts): void {
    this.#estimates = estimates;
    this.#facts = facts;
    this.#body.replaceChildren(...estimates.map((estimate) => this.#row(estimate)));
  }

  #row(estimate: Estimate): HTMLElement {
    const tone = statusTones[estimate.status];
    const elements = elementsOf(estimate);
    const axes = estimate.axes === 1 ? [0] : [0, 1];
    // What is not determined has no value, whatever its number is.
    const isDetermined = estimate.status !== EstimateStatus.ESTIMATE_UNDETERMINED;
    const known = (text: string): string => (isDetermined ? text : "–");
    const matrices = matrixNames.map((name) => {
      const { value, standard_error } = matrixOf(estimate, name);
      return stack("number", elements.map((i) => known(withError(value[i]!, standard_error[i]!))), unitOf(estimate, name));
    });
    const isMetric = estimate.displacement_unit === "m" || estimate.displacement_unit === "";
    const { value, standard_error } = estimate.spring_centre_m;
    const scale = isMetric ? 1000 : 1;
    const centre = axes.map((i) => known(withError(scale * value[i]!, scale * standard_error[i]!)));
    return el(
      "tr",
      { "data-estimate": hex(estimate.estimate_id) },
      stack("", [conditionOf(estimate)], methodOf(estimate)),
      el("td", { class: "long" }, el("div", { class: tone }, nameOf(statusNames, estimate.status)), el("div", { class: "faint" }, estimate.reasons.join("; "))),
      el("td", { class: "number" }, String(estimate.trials_used)),
      el("td", { class: estimate.trials_rejected > 0 ? "number warn" : "number" }, String(estimate.trials_rejected)),
      stack("faint", elements.map((i) => elementNames[i]!), ""),
      ...matrices,
      stack("number", centre, isMetric ? "mm" : estimate.displacement_unit),
      stack("number", axes.map((i) => known(estimate.sigma_N[i]!.toFixed(3))), estimate.force_unit || "N"),
    );
  }

  #download(): void {
    const url = URL.createObjectURL(new Blob([estimatesText(this.#estimates, ",", this.#facts)], { type: "text/csv" }));
    const session = this.#estimates[0] ? hex(this.#estimates[0].session_id).slice(0, 8) : "none";
    el("a", { href: url, download: `tonus-${this.#facts.subject ? `${this.#facts.subject}-` : ""}${session}.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }
}
