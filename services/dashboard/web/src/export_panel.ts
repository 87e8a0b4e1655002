// Exports of the open session, and reports of a cohort: ordered here, made in the background, with progress.

import { getJson, post, token } from "./access";
import { el, panel, setText } from "./dom";
import { jobLine, type Job } from "./job_words";

const formats: readonly [string, string][] = [["bids", "BIDS"], ["hdf5", "HDF5"], ["csv", "CSV"], ["xdf", "XDF"]];
const LOOK_MS = 700;

export interface ExportActions {
  say: (text: string, isBad?: boolean) => void;
  /// A report has been made.
  changed: () => void;
}

export class ExportPanel {
  readonly root: HTMLElement;
  #age: HTMLElement;
  #actions: ExportActions;
  #session = "";
  #ended = new Set<number>();
  #timer = 0;
  #list = el("ul", { id: "jobs", class: "plain", "aria-live": "polite" });
  #name = el("input", { id: "report-name", size: 12, maxlength: 64, placeholder: "pilot" });
  #cohort = el("input", { id: "report-cohort", type: "file", accept: ".toml" });

  constructor(actions: ExportActions) {
    this.#actions = actions;
    const exports = formats.map(([format, name]) => {
      const button = el("button", { type: "button", "data-export": format }, name);
      button.addEventListener("click", () => void this.#export(format));
      return button;
    });
    const make = el("button", { type: "submit", id: "make-report" }, "Make the report");
    const form = el(
      "form",
      { class: "row", "aria-label": "Report" },
      el("label", {}, "Report's name", this.#name),
      el("label", {}, "Cohort (TOML: the subjects and their link lengths)", this.#cohort),
      make,
    );
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#report();
    });
    const made = panel(
      "Exports and reports",
      "exports",
      el("div", { class: "row", role: "group", "aria-label": "Export of the open session" }, el("span", {}, "Export the open session as"), ...exports),
      form,
      this.#list,
    );
    this.root = made.root;
    this.#age = made.age;
    void this.refresh();
  }

  showSession(id: string): void {
    this.#session = id;
  }

  async #export(format: string): Promise<void> {
    if (!this.#session) return this.#actions.say("Export: open a session first.", true);
    await this.#order(`/api/sessions/${this.#session}/exports?format=${format}`, "", "Export");
  }

  async #report(): Promise<void> {
    const file = this.#cohort.files?.[0];
    if (!file) return this.#actions.say("Report: no cohort is chosen; expected its TOML file.", true);
    await this.#order(`/api/reports?name=${encodeURIComponent(this.#name.value.trim())}`, await file.text(), "Report");
  }

  async #order(path: string, body: string, what: string): Promise<void> {
    try {
      await post(path, body);
      this.#actions.say(`${what}: under way.`);
    } catch (error) {
      this.#actions.say(`${what}: ${(error as Error).message}`, true);
    }
    await this.refresh();
  }

  /// Reads how far the jobs are, again and again while one is not done.
  async refresh(): Promise<void> {
    clearTimeout(this.#timer);
    try {
      const jobs = await getJson<Job[]>("/api/jobs");
      this.#show(jobs);
      if (jobs.some(({ state }) => state === "waiting" || state === "running")) this.#timer = window.setTimeout(() => void this.refresh(), LOOK_MS);
    } catch (error) {
      setText(this.#age, (error as Error).message);
    }
  }

  #show(jobs: readonly Job[]): void {
    const going = jobs.filter(({ state }) => state === "waiting" || state === "running").length;
    setText(this.#age, going > 0 ? `${going} under way` : "");
    this.#list.replaceChildren(...[...jobs].reverse().map(entry));
    const news = jobs.filter(({ number, state, what }) => state === "done" && what === "report" && !this.#ended.has(number));
    for (const { number } of news) this.#ended.add(number);
    if (news.length > 0) this.#actions.changed();
  }
}

function entry(job: Job): HTMLElement {
  const bar = el("progress", { max: Math.max(1, job.total), "aria-label": `${job.what} ${job.subject}` });
  if (job.state === "done") bar.value = Math.max(1, job.total);
  else if (job.total > 0) bar.value = job.done;
  const secret = token();
  const link = el("a", { href: `${job.path}${secret ? `?token=${encodeURIComponent(secret)}` : ""}`, download: job.what === "export" ? "" : undefined, target: job.what === "report" ? "_blank" : undefined, rel: "noopener" }, job.what === "export" ? "Download" : "Open");
  return el("li", { "data-job": job.number, class: job.state === "failed" ? "bad" : undefined }, el("span", {}, jobLine(job), " "), ...(job.state === "done" ? [link] : job.state === "failed" ? [] : [bar]));
}
