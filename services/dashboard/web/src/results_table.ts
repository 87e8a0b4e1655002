// All estimates as a table, to read, copy and take away.

import { hex, statusNames, type Estimate } from "./contract";
import { el } from "./dom";
import { conditionOf, elementNames, elementsOf, matrixNames, matrixOf, methodOf, unitOf, withError } from "./matrices";

export interface TableActions {
  say: (text: string, isBad?: boolean) => void;
}

export class ResultsTable {
  readonly root = el("div");
  #estimates: Estimate[] = [];
  #body = el("tbody", { id: "estimates" });

  constructor({ say }: TableActions) {
    const copy = el("button", { type: "button", id: "copy" }, "Copy table");
    const download = el("button", { type: "button", id: "download" }, "Download CSV");
    copy.addEventListener("click", () => {
      navigator.clipboard.writeText(this.text("\t")).then(
        () => say(`Copied ${this.#estimates.length} estimates.`),
        (error: Error) => say(`Not copied: ${error.message}. Download works.`, true),
      );
    });
    download.addEventListener("click", () => this.#download());
    const head = el(
      "tr",
      {},
      ...["Condition", "Method", "Status", "Trials"].map((name) => el("th", { scope: "col" }, name)),
      ...["M", "B", "K", "Spring centre (mm)", "σ"].map((name) => el("th", { scope: "col", class: "number" }, name)),
    );
    this.root.append(
      el("div", { class: "row" }, copy, download),
      el("div", { class: "scroll", tabindex: 0 }, el("table", {}, el("thead", {}, head), this.#body)),
    );
  }

  update(estimates: Estimate[]): void {
    this.#estimates = estimates;
    this.#body.replaceChildren(...estimates.map((estimate) => this.#row(estimate)));
  }

  #row(estimate: Estimate): HTMLElement {
    const tone = estimate.status === 0 ? "good" : estimate.status === 1 ? "faint" : "warn";
    const cells = matrixNames.map((name) => {
      const matrix = matrixOf(estimate, name);
      const cell = el("td", { class: "number" });
      for (const i of elementsOf(estimate))
        cell.append(el("div", {}, withError(matrix.value[i]!, matrix.standard_error[i]!)));
      cell.append(el("div", { class: "faint" }, unitOf(estimate, name)));
      return cell;
    });
    const spring = el("td", { class: "number" });
    const { value, standard_error } = estimate.spring_centre_m;
    for (const i of estimate.axes === 1 ? [0] : [0, 1])
      spring.append(el("div", {}, withError(1000 * value[i]!, 1000 * standard_error[i]!)));
    return el(
      "tr",
      { "data-estimate": hex(estimate.estimate_id) },
      el("td", {}, conditionOf(estimate)),
      el("td", {}, methodOf(estimate)),
      el("td", { class: tone, title: estimate.reasons.join("; ") }, statusNames[estimate.status] ?? "?"),
      el("td", {}, `${estimate.trials_used} used, ${estimate.trials_rejected} rejected`),
      ...cells,
      spring,
      el("td", { class: "number" }, Array.from(estimate.sigma_N, (sigma) => sigma.toFixed(3)).join(", ")),
    );
  }

  /// Every number in full, one line an estimate; units in the heads.
  text(separator: string): string {
    const quote = (field: string): string =>
      /[",\t\n]/.test(field) ? `"${field.replaceAll('"', '""')}"` : field;
    const heads = [
      "condition", "posture_x_m", "posture_y_m", "bias_x_N", "bias_y_N", "set", "instruction", "method", "model",
      "status", "trials_used", "trials_rejected",
    ];
    const matrixHeads = ["M_kg", "B_Ns_per_m", "K_N_per_m"].flatMap((matrix) =>
      elementNames.flatMap((name) => [`${matrix}_${name}`, `${matrix}_${name}_se`, `${matrix}_${name}_low95`, `${matrix}_${name}_high95`]),
    );
    const lines = [[...heads, ...matrixHeads, "spring_x_m", "spring_y_m", "sigma_x_N", "sigma_y_N", "displacement_unit", "force_unit"]];
    for (const estimate of this.#estimates) {
      const numbers = matrixNames.flatMap((name) => {
        const matrix = matrixOf(estimate, name);
        return elementNames.flatMap((_, i) => [matrix.value[i]!, matrix.standard_error[i]!, matrix.low95[i]!, matrix.high95[i]!]);
      });
      lines.push(
        [
          conditionOf(estimate), ...estimate.posture_m, ...estimate.bias_N, estimate.set_number, estimate.instruction,
          estimate.method, estimate.model, statusNames[estimate.status] ?? "?", estimate.trials_used,
          estimate.trials_rejected, ...numbers, ...estimate.spring_centre_m.value, ...estimate.sigma_N,
          estimate.displacement_unit, estimate.force_unit,
        ].map(String),
      );
    }
    return lines.map((line) => line.map(quote).join(separator)).join("\n") + "\n";
  }

  #download(): void {
    const url = URL.createObjectURL(new Blob([this.text(",")], { type: "text/csv" }));
    const session = this.#estimates[0] ? hex(this.#estimates[0].session_id).slice(0, 8) : "none";
    el("a", { href: url, download: `tonus-${session}.csv` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }
}
