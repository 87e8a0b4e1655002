// Estimates as lines of text, for spreadsheets and programs.

import type { Estimate } from "./contract";
import { ellipseNumberNames, intervalOf } from "./ellipse_numbers";
import { conditionOf, elementNames, matrixNames, matrixOf } from "./matrices";
import { hex, nameOf, statusNames } from "./names";

/// Of the session's plan.
export interface SessionFacts {
  subject: string;
  protocol: string;
  seed: string;
  started_at: string;
  software_version: string;
  operator: string;
  study: string;
  is_pilot: string; // yes or no
}

export const noFacts: SessionFacts = { subject: "", protocol: "", seed: "", started_at: "", software_version: "", operator: "", study: "", is_pilot: "" };

const heads = [
  "session", "subject", "protocol", "seed", "started_at", "software_version", "operator", "study", "is_pilot", "condition", "posture_x_m", "posture_y_m", "bias_x_N", "bias_y_N", "set", "instruction", "method", "model",
  "status", "reasons", "trials_used", "trials_rejected",
  ...["M_kg", "B_Ns_per_m", "K_N_per_m"].flatMap((matrix) =>
    elementNames.flatMap((name) => ["", "_se", "_low95", "_high95"].map((what) => `${matrix}_${name}${what}`)),
  ),
  ...["M", "B", "K"].flatMap((matrix) =>
    ["size_unit2", "shape", "orientation_deg", "curl"].flatMap((name) => [`${matrix}_${name}`, `${matrix}_${name}_low95`, `${matrix}_${name}_high95`]),
  ),
  "spring_x_m", "spring_y_m", "sigma_x_N", "sigma_y_N", "displacement_unit", "force_unit",
];

/// Size, shape, orientation and curl with their 95 % intervals; empty where the matrix has no ellipse, and where an
/// interval is not known.
function ellipseFields(estimate: Estimate): (string | number)[] {
  return matrixNames.flatMap((name): (string | number)[] => {
    const matrix = matrixOf(estimate, name);
    if (!matrix.has_ellipse) return ellipseNumberNames.flatMap(() => ["", "", ""]);
    return ellipseNumberNames.flatMap((number) => [matrix[number], ...(intervalOf(matrix, number) ?? ["", ""])]);
  });
}

function fieldsOf(estimate: Estimate, facts: SessionFacts): (string | number)[] {
  const numbers = matrixNames.flatMap((name) => {
    const { value, standard_error, low95, high95 } = matrixOf(estimate, name);
    return elementNames.flatMap((_, i) => [value[i]!, standard_error[i]!, low95[i]!, high95[i]!]);
  });
  return [
    hex(estimate.session_id), facts.subject, facts.protocol, facts.seed, facts.started_at, facts.software_version, facts.operator, facts.study, facts.is_pilot,
    conditionOf(estimate), ...estimate.posture_m, ...estimate.bias_N, estimate.set_number, estimate.instruction,
    estimate.method, estimate.model, nameOf(statusNames, estimate.status), estimate.reasons.join("; "), estimate.trials_used,
    estimate.trials_rejected, ...numbers, ...ellipseFields(estimate), ...estimate.spring_centre_m.value, ...estimate.sigma_N,
    estimate.displacement_unit, estimate.force_unit,
  ];
}

const quoted = (field: string): string => (/[",\t\n]/.test(field) ? `"${field.replaceAll('"', '""')}"` : field);

/// Every number in full, one line an estimate; units in the heads.
export function estimatesText(estimates: Estimate[], separator: string, facts: SessionFacts = noFacts): string {
  const lines = [heads, ...estimates.map((estimate) => fieldsOf(estimate, facts))];
  return lines.map((line) => line.map((field) => quoted(String(field))).join(separator)).join("\n") + "\n";
}
