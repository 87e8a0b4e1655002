// Drives the pages of a running system through one session.
//
//   node session_in_browser.cjs PACKAGES CHROMIUM URL PROTOCOL PID_OF_TONUS_UP FOLDER SCREENSHOTS
//
// Writes FOLDER/live.csv, archive.csv and seen.json, and PNG files to SCREENSHOTS.

const { createRequire } = require("node:module");
const { execFileSync } = require("node:child_process");
const { writeFileSync } = require("node:fs");
const { join } = require("node:path");

const [packages, executablePath, url, protocol, systemId, folder, screenshots] = process.argv.slice(2);
const { chromium } = createRequire(`${packages}/package.json`)("playwright-core");
const STEP_MS = 60000;

function expect(condition, what) {
  if (!condition) throw new Error(`not so: ${what}`);
}

const text = (page, selector) => page.locator(selector).innerText();

/// Waits until a text of the page satisfies the condition.
async function until(page, selector, condition, what) {
  const deadline = Date.now() + STEP_MS;
  let seen = "";
  while (Date.now() < deadline) {
    seen = await text(page, selector);
    if (condition(seen)) return seen;
    await page.waitForTimeout(50);
  }
  throw new Error(`${what}: ${selector} says "${seen}"`);
}

const phase = (page, ...wanted) => until(page, "#phase", (seen) => wanted.includes(seen), `phase ${wanted}`);
/// Waits for a state of the strip, and for what it says.
const strip = async (page, state, ...parts) => {
  await page.locator(`#strip[data-state="${state}"]`).waitFor({ timeout: STEP_MS });
  return until(page, "#strip p", (seen) => parts.every((part) => seen.includes(part)), `strip says ${parts}`);
};
const shot = (page, name, options = {}) => page.screenshot({ path: join(screenshots, `${name}.png`), ...options });

async function download(page, file) {
  const [given] = await Promise.all([page.waitForEvent("download"), page.click("#download")]);
  await given.saveAs(join(folder, file));
}

/// By keyboard alone: on from where the focus is, to the element with this id.
async function tabTo(page, id) {
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("Tab");
    if ((await page.evaluate(() => document.activeElement?.id)) === id) return;
  }
  throw new Error(`the keyboard does not reach #${id}`);
}

async function framesPerSecond(page) {
  const frames = () => page.evaluate(() => Number(document.querySelector(".trace").dataset.frames));
  const [first, begin] = [await frames(), Date.now()];
  await page.waitForTimeout(2000);
  return (1000 * ((await frames()) - first)) / (Date.now() - begin);
}

/// A file that is no protocol, then the list, then the right file: the one that is shown is the one that is sent.
async function chooseProtocol(page) {
  const wrong = join(folder, "wrong.toml");
  writeFileSync(wrong, "this is no protocol");
  await page.setInputFiles("#protocol-file", wrong);
  expect(await page.isChecked("#from-file"), "a file chosen is the file used");
  await until(page, "#preview", (seen) => seen.includes("not TOML"), "what is wrong with the file is shown before");
  await page.click("#start");
  await until(page, "#notice", (seen) => seen.startsWith("start: refused"), "the wrong file is refused");
  await page.selectOption("#protocol", "loaded");
  expect(await page.isChecked("#from-list"), "the list chosen is the list used");
  expect((await page.inputValue("#protocol-file")) === "", "the file chosen before is forgotten");
  await page.setInputFiles("#protocol-file", protocol);
}

async function start(page) {
  await until(page, "#link", (seen) => seen.includes("Connected (operate)"), "connection");
  await until(page, "#roster-age", (seen) => seen === "complete", "roster");
  await page.locator("#start[aria-disabled=false]").waitFor();
  await shot(page, "operator-before");
  await strip(page, "ready", "READY");
  await chooseProtocol(page);
  await page.fill("#operator", "Anna");
  await tabTo(page, "start");
  await page.keyboard.press("Enter");
  await until(page, "#notice", (seen) => seen.startsWith("start: done"), "answer to start");
  await phase(page, "running");
}

async function watch(page) {
  await page.locator("#verdicts tr").first().waitFor({ timeout: STEP_MS });
  expect((await text(page, "#verdicts")).includes("valid"), "a verdict is shown");
  console.log(`traces: ${(await framesPerSecond(page)).toFixed(0)} frames/s`);
  await shot(page, "operator-running");
}

async function pauseAndResume(page) {
  await page.click("#pause");
  await phase(page, "paused");
  await until(page, "#notice", (seen) => seen.startsWith("pause: done"), "answer to pause");
  await shot(page, "operator-paused");
  await page.keyboard.press("Alt+r");
  await phase(page, "running");
}

/// The emergency stop by keyboard, from this page; `answer`: where the page says what became of it.
async function stop(page, answer) {
  await page.keyboard.press("Control+Space");
  await until(page, answer, (seen) => seen.startsWith("Emergency stop done"), "answer to the emergency stop");
}

/// The rig refuses to be cleared until the handle is at rest: whoever reads that presses again.
async function clearOnceAtRest(page) {
  const deadline = Date.now() + STEP_MS;
  for (;;) {
    await page.locator("#clear-fault[aria-disabled=false]").click();
    const answer = await until(page, "#notice", (seen) => /^clear_fault: (done|refused)/.test(seen), "answer to clear");
    if (answer.startsWith("clear_fault: done")) return;
    expect(Date.now() < deadline, `the hold is cleared: ${answer}`);
    await page.waitForTimeout(200);
  }
}

/// Two acts: clearing frees the rig, and only resuming moves it again.
async function goOnAfterStop(page, ...said) {
  await until(page, "#fact-rig", (seen) => seen === "held", "the rig is held");
  await phase(page, "waiting");
  await strip(page, "stopped", "EMERGENCY STOP", ...said);
  await clearOnceAtRest(page);
  await until(page, "#fact-rig", (seen) => seen === "free", "the rig is free");
  await phase(page, "waiting");
  await page.locator("#resume[aria-disabled=false]").click();
  await phase(page, "running");
}

async function stopAndGoOn(page) {
  await stop(page, "#notice");
  await goOnAfterStop(page, "pressed ", "UTC on operator by Anna, dashboard 127.0.0.1", "Clear fault, then Resume");
}

/// The trial that is aborted is rejected and comes again once the operator resumes.
async function abortATrial(page) {
  await page.locator("#abort-trial[aria-disabled=false]").waitFor({ timeout: STEP_MS });
  await page.keyboard.press("Alt+t");
  await until(page, "#notice", (seen) => seen.startsWith("abort_trial: done"), "answer to the abort of a trial");
  await until(page, "#verdicts", (seen) => /rejected\s.*aborted/.test(seen), "the aborted trial is rejected");
  await strip(page, "paused", "YOUR TURN", "Resume when the subject is ready");
  expect(await page.evaluate(() => document.querySelector("#resume").classList.contains("main")), "the next action is the primary one");
  await page.keyboard.press("Alt+r");
  await strip(page, "running", "RUNNING trial");
}

/// The newest trial that counts, on display.
async function chooseValid(page) {
  const row = page.locator("#verdicts tr", { has: page.locator("td.good") }).first();
  await row.waitFor({ timeout: STEP_MS });
  const attempt = await row.locator("button").innerText();
  await row.locator("button").click();
  await until(page, "#last-trial-age", (seen) => seen.startsWith(`trial ${attempt}:`), "the chosen trial is shown");
  return attempt;
}

/// A trial that counts is rejected for a reason, another one repeated; both are left out and run again. Something is noted.
async function rejectRepeatAndNote(page) {
  const rejected = await chooseValid(page);
  await page.fill("#trial-text", "coughed");
  await page.click("#reject-trial");
  await until(page, "#notice", (seen) => seen.startsWith("reject_trial: done"), "answer to the rejection");
  await until(page, "#verdicts", (seen) => /rejected by hand\s+coughed/.test(seen), "the rejection is shown with its reason");
  const repeated = await chooseValid(page);
  await page.click("#repeat-trial");
  await until(page, "#verdicts", (seen) => /rejected by hand\s+repeat/.test(seen), "the repeat is shown as a rejection");
  await page.keyboard.press("Alt+n");
  await page.keyboard.type("light on");
  await page.keyboard.press("Enter");
  await until(page, "#notes", (seen) => seen.includes("light on"), "the note is shown");
  await shot(page, "operator-remarks", { fullPage: true });
  return { rejected: Number(rejected), repeated: Number(repeated) };
}

async function watchSubject(context, operator) {
  const page = await context.newPage();
  await page.goto(`${url}/subject`);
  await until(page, "#instruction", (seen) => seen.includes("Hold the handle on the circle"), "instruction");
  const canvas = (name) => page.evaluate((key) => document.querySelector("#target").dataset[key], name);
  const deadline = Date.now() + STEP_MS;
  while (!(await canvas("cursor"))) {
    expect(Date.now() < deadline, "the hand is shown");
    await page.waitForTimeout(50);
  }
  const pixelsPerCm = Number(await page.inputValue("#zoom"));
  expect(Math.abs(Number(await canvas("diameter")) - pixelsPerCm) < 1e-6, "the circle is 1 cm wide");
  await page.locator("#emergency-stop:visible").waitFor();
  await shot(page, "subject");
  await stop(page, "#trouble");
  await until(page, "#strip-text", (seen) => seen === "Let go. The experiment has stopped.", "the subject is told to let go");
  await shot(page, "subject-stopped");
  await page.close();
  await operator.bringToFront();
  await goOnAfterStop(operator, "UTC on subject by ");
}

async function killGateway(page) {
  const children = execFileSync("ps", ["-o", "pid=,comm=", "--ppid", systemId], { encoding: "utf8" });
  const line = children.split("\n").find((one) => one.includes("tonus-dashboar"));
  expect(line, "the gateway is a child of tonus up");
  process.kill(Number(line.trim().split(/\s+/)[0]), "SIGKILL");
  await until(page, "#link", (seen) => seen.includes("DISCONNECTED"), "the loss is said");
  await strip(page, "disconnected", "DISCONNECTED for", "Values below are old");
  await shot(page, "operator-disconnected");
  await until(page, "#link", (seen) => seen.includes("Connected"), "the page comes back by itself");
  await until(page, "#strip p", (seen) => !seen.includes("DISCONNECTED"), "the strip is of now again");
}

async function finish(page) {
  await phase(page, "completed");
  await shot(page, "operator-completed", { fullPage: true });
  const trials = await text(page, "#fact-trials");
  return {
    session: await text(page, "#fact-id"),
    verdicts: await page.locator("#verdicts tr").count(),
    counted: Number(trials.split(" ")[0]),
  };
}

async function lookAtResults(page) {
  await until(page, "#which", (seen) => seen.includes("completed"), "results of the session that is over");
  await page.waitForTimeout(1500); // the ellipses have grown
  await shot(page, "results", { fullPage: true });
  await download(page, "live.csv");
}

async function lookAtArchive(context, session) {
  const page = await context.newPage();
  await page.goto(`${url}/archive`);
  await page.locator(`[data-session="${session}"]`).click();
  await page.locator(`#session-facts[data-session="${session}"]`).waitFor();
  await page.waitForTimeout(1500);
  await shot(page, "archive", { fullPage: true });
  await download(page, "archive.csv");
  const [report] = await Promise.all([context.waitForEvent("page"), page.locator("#reports strong a", { hasText: "pilot" }).click()]);
  await report.waitForLoadState();
  expect((await text(report, "h1")) === "Pilot study", "the report is shown");
  expect(await report.evaluate(() => document.querySelector("img").naturalWidth > 0), "its figure is shown");
  expect(!(await report.evaluate(() => document.body.dataset.script)), "no script of a report runs");
  await report.close();
  await page.close();
}

async function lookInOtherWays(browser) {
  for (const [name, options] of [
    ["dark", { colorScheme: "dark", viewport: { width: 1280, height: 720 } }],
    ["tablet", { viewport: { width: 820, height: 1180 }, hasTouch: true }],
    ["tablet-across", { colorScheme: "dark", viewport: { width: 1180, height: 820 }, hasTouch: true }],
  ]) {
    const context = await browser.newContext(options);
    for (const path of ["", "results", "archive"]) {
      const page = await context.newPage();
      await page.goto(`${url}/${path}`);
      await until(page, "#link", (seen) => seen.includes("Connected"), "connection");
      await page.waitForTimeout(1500);
      const surplus = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      expect(surplus <= 0, `${path || "operator"} is no wider than a ${name} screen (${surplus} px)`);
      await shot(page, `${path || "operator"}-${name}`);
      await page.close();
    }
    await context.close();
  }
}

async function run(browser) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, acceptDownloads: true });
  const troubles = [];
  const foreign = [];
  context.on("page", (page) => {
    page.on("pageerror", (error) => troubles.push(error.message));
    page.on("request", (request) => {
      if (!/^(blob:|data:)/.test(request.url()) && !request.url().startsWith(url)) foreign.push(request.url());
    });
  });
  const page = await context.newPage();
  await page.goto(url);
  const results = await context.newPage();
  await results.goto(`${url}/results`);
  await page.bringToFront();
  await start(page);
  await watch(page);
  await pauseAndResume(page);
  await abortATrial(page);
  const remarks = await rejectRepeatAndNote(page);
  await watchSubject(context, page);
  await page.bringToFront();
  await stopAndGoOn(page);
  await killGateway(page);
  const seen = { ...(await finish(page)), ...remarks };
  await lookAtResults(results);
  await lookAtArchive(context, seen.session);
  await lookInOtherWays(browser);
  writeFileSync(join(folder, "seen.json"), JSON.stringify(seen));
  expect(troubles.length === 0, `no page has an error: ${troubles}`);
  expect(foreign.length === 0, `nothing comes from elsewhere: ${foreign}`);
}

(async () => {
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"] });
  try {
    await run(browser);
  } catch (error) {
    for (const context of browser.contexts())
      for (const page of context.pages()) await shot(page, `failure-${context.pages().indexOf(page)}`).catch(() => undefined);
    console.error(error.stack);
    process.exitCode = 1;
  } finally {
    await browser.close();
  }
})();
