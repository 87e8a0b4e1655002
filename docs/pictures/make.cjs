// Runs a protocol, and takes the two pictures: the ellipses as they form, the operator's page.
//
//   node make.cjs PACKAGES CHROMIUM URL FOLDER TONUS PROTOCOL

const { createRequire } = require("node:module");
const { spawn } = require("node:child_process");
const { join } = require("node:path");

const [packages, executablePath, url, folder, tonus, protocol] = process.argv.slice(2);
const { chromium } = createRequire(`${packages}/package.json`)("playwright-core");

async function main() {
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
  const page = (width, height) => browser.newPage({ viewport: { width, height }, colorScheme: "light" });
  const results = await page(1400, 1600);
  const operator = await page(1200, 760);
  await results.goto(`${url}/results`);
  await operator.goto(url);
  const run = spawn(tonus, ["run", protocol, "--seed", "7"], { stdio: "ignore" });
  const ended = new Promise((resolve) => run.on("exit", resolve));
  await operator.locator('#strip[data-state="running"]').waitFor({ timeout: 60000 });
  await operator.waitForTimeout(1200); // so that there is something to show
  await Promise.all([
    operator.screenshot({ path: join(folder, "operator.png") }),
    results.locator("#ellipses").screenshot({ path: join(folder, "ellipses.png") }),
  ]);
  const code = await ended;
  await browser.close();
  if (code !== 0) throw new Error(`the session ended with ${code}`);
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
