// Estimates as lines of text, for spreadsheets and programs.

import type { Estimate } from "./contract";
import { conditionOf, elementNames, matrixNames, matrixOf } from "./matrices";
import { nameOf, statusNames } from "./names";

const heads = [
  "condition", "posture_x_m", "posture_y_m", "bias_x_N", "bias_y_N", "set", "instruction", "method", "model",
  "status", "trials_used", "trials_rejected",
  ...["M_kg", "B_Ns_per_m", "K_N_per_m"].flatMap((matrix) =>
    elementNames.flatMap((name) => ["", "_se", "_low95", "_high95"].map((what) => `${matrix}_${name}${what}`)),
  ),
  "spring_x_m", "spring_y_m", "sigma_x_N", "sigma_y_N", "displacement_unit", "force_unit",
];

function fieldsOf(estimate: Estimate): (string | number)[] {
  const numbers = matrixNames.flatMap((name) => {
    const { value, standard_error, low95, high95 } = matrixOf(estimate, name);
    return elementNames.flatMap((_, i) => [value[i]!, standard_error[i]!, low95[i]!, high95[i]!]);
  });
  return [
    conditionOf(estimate), ...estimate.posture_m, ...estimate.bias_N, estimate.set_number, estimate.instruction,
    estimate.method, estimate.model, nameOf(statusNames, estimate.status), estimate.trials_used,
    estimate.trials_rejected, ...numbers, ...estimate.spring_centre_m.value, ...estimate.sigma_N,
    estimate.displacement_unit, estimate.force_unit,
  ];
}

const quoted = (field: string): string => (/[",\t\n]/.test(field) ? `"${field.replaceAll('"', '""')}"` : field);

/// Every number in full, one line an estimate; units in the heads.
export function estimatesText(estimates: Estimate[], separator: string): string {
  const lines = [heads, ...estimates.map(fieldsOf)];
  return lines.map((line) => line.map((field) => quoted(String(field))).join(separator)).join("\n") + "\n";
}
