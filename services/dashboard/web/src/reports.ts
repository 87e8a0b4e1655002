// Reports as they lie in the data folder: a folder each, with a page and its figures and tables.

export interface ReportFile {
  path: string; // within the folder of reports
  bytes: number;
  modified: string; // ISO 8601, UTC
}

export interface Report {
  name: string;
  page?: string; // path of what is to be opened first
  modified: string; // of the newest file
  files: string[]; // paths of what can be read, in order
}

const READABLE = /\.(html|pdf|svg|csv)$/;

/// Newest report first; files of no folder are a report each.
export function groupReports(files: ReportFile[]): Report[] {
  const reports = new Map<string, Report>();
  for (const { path, modified } of files.filter((file) => READABLE.test(file.path))) {
    const name = path.includes("/") ? path.slice(0, path.lastIndexOf("/")) : path;
    const report = reports.get(name) ?? { name, modified, files: [] };
    report.files.push(path);
    if (modified > report.modified) report.modified = modified;
    if (path === name || path.endsWith("/index.html")) report.page = path;
    reports.set(name, report);
  }
  for (const report of reports.values()) report.files.sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
  return [...reports.values()].sort((a, b) => b.modified.localeCompare(a.modified));
}
