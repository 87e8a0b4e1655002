// The name of the person at this browser, which goes with every request.

const KEY = "tonus-operator";
export const LONGEST_NAME = 40;

/// Letters, digits and a few marks; what could be read as another part of the record is left out.
export const cleanName = (text: string): string =>
  text.replace(/[^\p{L}\p{N} .'_-]/gu, "").replace(/\s+/g, " ").trim().slice(0, LONGEST_NAME);

export const operatorName = (): string => cleanName(localStorage.getItem(KEY) ?? "");
export const keepOperatorName = (name: string): void => localStorage.setItem(KEY, cleanName(name));
