// Prints the licences of the npm packages that the pages are made of: those of package-lock.json that are no tools.
//   node licences.mjs FOLDER    the folder with package-lock.json and node_modules
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";

const folder = process.argv[2];
const lock = JSON.parse(readFileSync(join(folder, "package-lock.json"), "utf8"));
for (const [path, entry] of Object.entries(lock.packages).sort()) {
  if (path === "" || entry.dev || entry.optional) continue;
  const place = join(folder, path);
  console.log(`==== ${path.replace(/^.*node_modules\//, "")} ${entry.version}: ${entry.license ?? "see below"}\n`);
  if (!existsSync(place)) throw new Error(`${place} is missing; npm ci installs it`);
  for (const file of readdirSync(place).filter((name) => /^(licen[sc]e|copying|notice)/i.test(name)).sort())
    console.log(readFileSync(join(place, file), "utf8"));
}
