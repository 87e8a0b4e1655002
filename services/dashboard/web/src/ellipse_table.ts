// Size, shape, orientation and curl of each matrix as a table, and how well each posture is known as a list.

import { EstimateStatus, type Estimate } from "./contract";
import { el } from "./dom";
import { ellipseNumberNames, intervalOf, relativeHalfWidth, withInterval } from "./ellipse_numbers";
import { conditionOf, elementsOf, matrixNames, matrixOf, postureOf, toneClass, unitOf, type MatrixName } from "./matrices";
import { colourOf, keyOf } from "./posture_style";

export function ellipseTable(body: HTMLElement): HTMLElement {
  const head = el(
    "tr",
    {},
    ...["Condition", "Matrix"].map((name) => el("th", { scope: "col" }, name)),
    ...["Size", "Shape", "Orientation (deg)", "Curl"].map((name) => el("th", { scope: "col", class: "number" }, name)),
  );
  return el("div", { class: "scroll steady", tabindex: 0, role: "group", "aria-label": "Size, shape, orientation, curl" }, el("table", {}, el("thead", {}, head), body));
}

/// Of estimates of the plane that have an ellipse; the others say why not.
export function ellipseRows(estimates: Estimate[]): HTMLElement[] {
  return estimates
    .filter((estimate) => estimate.axes !== 1)
    .flatMap((estimate) => matrixNames.map((name) => ellipseRow(estimate, name)));
}

function ellipseRow(estimate: Estimate, name: MatrixName): HTMLElement {
  const matrix = matrixOf(estimate, name);
  const heads = [el("td", {}, conditionOf(estimate)), el("td", {}, name)];
  if (estimate.status === EstimateStatus.ESTIMATE_UNDETERMINED || !matrix.has_ellipse) {
    const why = estimate.status === EstimateStatus.ESTIMATE_UNDETERMINED ? "undetermined" : "no ellipse: the symmetric part is not positive definite";
    return el("tr", {}, ...heads, el("td", { class: "faint", colspan: 4 }, why));
  }
  const unit = unitOf(estimate, name);
  const units: Record<string, string> = { size: unit.includes(" ") || unit.includes("/") ? ` (${unit})²` : ` ${unit}²`, shape: "", orientation_deg: "", curl: "" };
  const cells = ellipseNumberNames.map((number) => el("td", { class: "number" }, withInterval(matrix[number], intervalOf(matrix, number)) + units[number]!));
  return el("tr", {}, ...heads, ...cells);
}

/// "K ±2.1 % after 6 of 8 trials", a line for each posture.
export function progressList(estimates: Estimate[], name: MatrixName, planned: ReadonlyMap<string, number>, places: ReadonlyMap<string, number>): HTMLElement[] {
  return estimates.map((estimate) => {
    const place = places.get(postureOf(estimate)) ?? 0;
    return el("li", { class: toneClass(colourOf(place)) }, keyOf(place), el("span", {}, el("strong", {}, conditionOf(estimate)), ` ${progressText(estimate, name, planned.get(postureOf(estimate)))}`));
  });
}

export function progressText(estimate: Estimate, name: MatrixName, planned: number | undefined): string {
  const trials = `${estimate.trials_used}${planned === undefined ? "" : ` of ${planned}`} trials`;
  const rejected = estimate.trials_rejected > 0 ? `, ${estimate.trials_rejected} rejected` : "";
  if (estimate.status === EstimateStatus.ESTIMATE_UNDETERMINED) return `undetermined after ${trials}${rejected}`;
  const share = relativeHalfWidth(matrixOf(estimate, name), elementsOf(estimate));
  const known = Number.isFinite(share) ? `${name} ±${(100 * share).toFixed(1)} % of its largest element` : `${name}: interval unknown`;
  const suspect = estimate.status === EstimateStatus.ESTIMATE_SUSPECT ? "; suspect" : "";
  return `${known} after ${trials}${rejected}${suspect}`;
}
