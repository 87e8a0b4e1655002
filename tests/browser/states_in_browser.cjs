// Every state of the desk on every page: what the strip says, accessibility, sizes, layout shift. Behind the pages is a
// scripted gateway, so that each state lasts as long as a look at it.
//
//   node states_in_browser.cjs PACKAGES CHROMIUM PAGES IDL SCREENSHOTS [--all | --scenarios | --only NAME]
//
// --all looks at every state of every page in every size and scheme; without it, each page has two of the six.
// --scenarios leaves the states out; --only runs one scenario, by its function's name.

const { createRequire } = require("node:module");
const { join } = require("node:path");
const { mkdirSync } = require("node:fs");
const { gzipSync } = require("node:zlib");
const { ScriptedGateway } = require("./scripted_gateway.cjs");
const { states, Desk, archive } = require("./desk_states.cjs");
const further = [...require("./remark_scenarios.cjs").scenarios, ...require("./page_scenarios.cjs").scenarios];

const [packages, executablePath, pages, idl, screenshots, mode, only] = process.argv.slice(2);
const require_ = createRequire(join(packages, "package.json"));
const { chromium } = require_("playwright-core");
const axePath = require_.resolve("axe-core/axe.min.js");
const STEP_MS = 20000;
const LARGEST_SHIFT = 0.02;
const SMALLEST_TEXT_PX = 11;
const LARGEST_LOAD_BYTES = 100_000;

const paths = ["", "results", "subject", "archive", "studies", "protocols"];
const looks = ["light", "dark"].flatMap((colorScheme) =>
  [[1280, 720], [820, 1180], [390, 844]].map(([width, height]) => ({ colorScheme, viewport: { width, height } })),
);
const failures = [];
const fail = (what) => {
  failures.push(what);
  console.error(`not so: ${what}`);
};

async function until(condition, what) {
  const deadline = Date.now() + STEP_MS;
  let seen;
  while (Date.now() < deadline) {
    const [isSo, found] = await condition();
    if (isSo) return;
    seen = found;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  fail(`${what}; seen: ${seen}`);
}

const stripOf = (page) => page.evaluate(() => ["#strip-head", "#strip-text"].map((id) => document.querySelector(id)?.textContent ?? "").join(" ").trim());

async function says(page, path, state, where) {
  if (path === "subject") return until(async () => { const seen = await stripOf(page); return [seen === state.subject, seen]; }, `${where} says "${state.subject}"`);
  return until(async () => { const seen = await stripOf(page); return [state.strip.test(seen), seen]; }, `${where} says ${state.strip}`);
}

/// What is wrong with the page as it stands: rules of accessibility, width, small text, the place of the stop.
async function look(page, where) {
  const found = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  for (const { id, nodes } of found.violations) fail(`${where}: axe ${id}: ${nodes.slice(0, 3).map((node) => `${node.html.slice(0, 120)} ${node.any[0]?.message ?? ""}`).join(" | ")}`);
  const measured = await page.evaluate((smallest) => {
    const stop = document.querySelector("#emergency-stop").getBoundingClientRect();
    const small = [];
    for (const element of document.body.querySelectorAll("*")) {
      const hasText = Array.from(element.childNodes).some((node) => node.nodeType === 3 && node.textContent.trim());
      if (!hasText || !element.getClientRects().length) continue;
      const scale = element instanceof SVGElement && element.getScreenCTM ? element.getScreenCTM().a : 1;
      const size = parseFloat(getComputedStyle(element).fontSize) * scale;
      if (size < smallest - 0.05) small.push(`${element.textContent.slice(0, 20)}: ${size.toFixed(1)} px`);
    }
    return { surplus: document.documentElement.scrollWidth - innerWidth, stop: [innerWidth - stop.right, stop.top, stop.width, stop.height], small };
  }, SMALLEST_TEXT_PX);
  if (measured.surplus > 0) fail(`${where}: ${measured.surplus} px wider than the screen`);
  if (measured.small.length > 0) fail(`${where}: small text: ${measured.small.slice(0, 4).join(", ")}`);
  return measured.stop.map((n) => n.toFixed(1)).join(" ");
}

async function openPage(browser, gateway, path, options) {
  const context = await browser.newContext(options);
  await context.addInitScript({ path: axePath });
  await context.addInitScript(() => {
    globalThis.shifts = [];
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) globalThis.shifts.push({ value: entry.value, what: entry.sources.map(({ node }) => node?.id || node?.className || node?.nodeName).join(",") });
    }).observe({ type: "layout-shift", buffered: true });
  });
  const page = await context.newPage();
  page.on("pageerror", (error) => fail(`${path || "operator"}: ${error.message}`));
  await page.goto(`${gateway.url}/${path}${path === "archive" ? `#${"5a".repeat(16)}` : ""}`);
  return page;
}

/// A picture of a whole page resizes the window for a moment: what shifts then is no transition.
async function picture(page, take) {
  const before = await page.evaluate(() => globalThis.shifts.length);
  await take();
  await page.waitForTimeout(150);
  await page.evaluate((length) => { globalThis.shifts.length = Math.min(length, globalThis.shifts.length); }, before);
}

/// One page in one size and scheme through all states.
async function walk(browser, gateway, desk, path, lookNumber, stops) {
  const options = looks[lookNumber];
  const name = `${path || "operator"} ${options.viewport.width} ${options.colorScheme}`;
  desk.enter(states[0]);
  const page = await openPage(browser, gateway, path, options);
  await says(page, path, states[0], name);
  await page.waitForTimeout(500);
  await page.evaluate(() => { globalThis.shifts.length = 0; }); // of loading; transitions count from here
  for (const [i, state] of states.entries()) {
    const where = `${name}, ${state.name}`;
    desk.enter(state);
    await says(page, path, state, where);
    await page.waitForTimeout(300); // every part of the page has drawn the state
    if (mode === "--all" || i % 2 === 0) stops.add(await look(page, where));
    if (mode === "--all" || i % 4 === 0)
      await picture(page, () => page.screenshot({ fullPage: path !== "" || options.viewport.width < 800, path: join(screenshots, `state-${state.name}-${path || "operator"}-${options.viewport.width}-${options.colorScheme}.png`) }));
  }
  const shifts = await page.evaluate(() => globalThis.shifts);
  const sum = shifts.reduce((all, { value }) => all + value, 0);
  console.log(`${name}: layout shift ${sum.toFixed(4)}`);
  if (sum >= LARGEST_SHIFT) fail(`${name}: layout shift ${sum.toFixed(4)} of ${JSON.stringify(shifts.slice(0, 6))}`);
  await page.context().close();
}

const stateOf = (page) => page.evaluate(() => document.querySelector("#strip").dataset.state);
const named = (name) => states.find((state) => state.name === name);

/// Two operators: what one asks, both see; a control that cannot be pressed keeps the focus and says why.
async function twoOperators(browser, gateway, desk) {
  gateway.forgetAll();
  desk.enter(named("running"));
  const [one, other] = [await openPage(browser, gateway, "", looks[0]), await openPage(browser, gateway, "", looks[4])];
  for (const page of [one, other]) await says(page, "", named("running"), "two operators");
  gateway.reply = ({ request_id, request }) => {
    if (request === "pause") desk.enter(named("paused"));
    return { request_id, request, is_done: true, message: "done", requested_by: "test" };
  };
  gateway.requests.length = 0;
  await one.fill("#operator", "Anna");
  await one.locator("#pause").focus();
  await one.keyboard.press("Enter");
  for (const page of [one, other]) await says(page, "", named("paused"), "two operators");
  const asked = gateway.requests.find(({ request }) => request === "pause");
  if (asked?.by !== "Anna" || asked?.page !== "operator") fail(`a request tells who asks and where; seen: ${JSON.stringify(asked)}`);
  await until(async () => { const seen = await one.evaluate(() => [document.activeElement.id, document.querySelector("#pause").getAttribute("aria-disabled")].join(" ")); return [seen === "pause true", seen]; }, "a control that cannot be pressed any more keeps the focus");
  await one.keyboard.press("Alt+p");
  await until(async () => { const seen = await one.textContent("#notice"); return [seen === "Pause is not possible now: paused.", seen]; }, "it says why");
  const sent = gateway.requests.filter(({ request }) => request === "pause").length;
  if (sent !== 1) fail(`the pause was sent ${sent} times`);
  for (const page of [one, other]) await page.context().close();
}

/// A gateway that hangs is told from one that has nothing to say.
async function hangingGateway(browser, gateway, desk) {
  gateway.forgetAll();
  desk.enter(named("running"));
  const page = await openPage(browser, gateway, "results", looks[1]);
  await says(page, "results", named("running"), "before the gateway hangs");
  desk.end();
  gateway.isSilent = true;
  await until(async () => { const seen = await stateOf(page); return [seen === "disconnected" || seen === "rig-gone", seen]; }, "a hanging gateway is not taken for a running session");
  gateway.isSilent = false;
  desk.enter(named("running"));
  await says(page, "results", named("running"), "after the gateway hung");
  await page.context().close();
}

/// Every page on a phone, whichever sizes its states were looked at in.
async function phone(browser, gateway, desk, stops) {
  for (const path of paths) {
    gateway.forgetAll();
    desk.enter(named("running"));
    const page = await openPage(browser, gateway, path, looks[2]);
    await says(page, path, named("running"), `${path || "operator"} on a phone`);
    await page.waitForTimeout(1000);
    stops.add(await look(page, `${path || "operator"} on a phone`));
    await page.context().close();
  }
}

/// Sessions of the archive over each other: ellipses, elements in the order of time, and differences, which are those of the
/// scripted matrices.
async function compareSessions(browser, gateway, desk, stops) {
  for (const lookNumber of [0, 5]) {
    gateway.forgetAll();
    desk.enter(named("completed"));
    const page = await openPage(browser, gateway, "archive", looks[lookNumber]);
    const name = `compared sessions, ${looks[lookNumber].viewport.width}`;
    await page.locator("#session-facts[data-session]").waitFor({ timeout: STEP_MS });
    const facts = await page.textContent("#session-facts");
    if (!facts.includes("operator Anna, study cohort, a pilot, no part of a study's results.")) fail(`${name}: the session's operator, study and pilot mode are shown; seen: ${facts}`);
    const sessions = () => page.locator("#compared-sessions li").allTextContents();
    await page.click("#compare-subject");
    await until(async () => { const seen = await sessions(); return [seen.length === 2 && /^A: sub-07, .*\(open\)$/.test(seen[0]) && /^B: sub-07, unloaded, 2026-02-23 10:15/.test(seen[1]), seen]; }, `${name}: the subject's other session is chosen`);
    await page.locator(`[data-compare="${"5b".repeat(16)}"]`).focus();
    await page.keyboard.press("Space");
    await until(async () => { const seen = await sessions(); return [seen.length === 3 && seen[2].startsWith("C: sub-08"), seen]; }, `${name}: a third one by keyboard`);
    const seen = await page.evaluate(() => ({
      facts: document.querySelector("#session-facts").dataset.session,
      ellipses: Array.from(document.querySelectorAll("#overlay figure:last-of-type .ellipse"), (one) => [one.dataset.condition, one.getAttribute("stroke-dasharray")].join(" ")),
      letters: Array.from(document.querySelectorAll("#over-time svg > text:not([text-anchor=end])"), (one) => one.textContent).filter((one) => /^[A-F]$/.test(one)),
      rows: Array.from(document.querySelectorAll("#differences tr"), (row) => Array.from(row.cells, (cell) => cell.textContent).join("; ")),
      own: document.querySelector(`[data-compare="${"5a".repeat(16)}"]`).disabled,
      focus: document.activeElement.dataset.compare,
    }));
    if (seen.facts !== "5a".repeat(16)) fail(`${name}: the open session stays open; seen: ${seen.facts}`);
    if (seen.focus !== "5b".repeat(16)) fail(`${name}: the focus stays; seen: ${seen.focus}`);
    if (!seen.own) fail(`${name}: a session is not compared with itself`);
    if (seen.ellipses.length !== 6 || new Set(seen.ellipses).size !== 6) fail(`${name}: two postures of three sessions, each with its dash; seen: ${seen.ellipses}`);
    if (seen.letters.join("") !== "BAC") fail(`${name}: in the order of their start; seen: ${seen.letters}`);
    // 220 - 180, errors 4 and 2 with the quantile 1.97: 1.97 * sqrt(16 + 4); 220 - 260: 1.97 * sqrt(16 + 25).
    for (const wanted of ["B; reference; Kxx; 220.0; 180.0; 40.0 ± 8.8 *; N/m", "C; reference; Kxx; 220.0; 260.0; -40 ± 13 *; N/m", "B; reference; Kyy; 140.0; 140.0; 0.0 ± 8.8; N/m"])
      if (!seen.rows.includes(wanted)) fail(`${name}: "${wanted}" among the differences; seen: ${seen.rows.filter((row) => /; K/.test(row)).join(" | ")}`);
    await page.waitForTimeout(1000); // the ellipses have grown
    stops.add(await look(page, name));
    await page.screenshot({ fullPage: true, path: join(screenshots, `archive-compared-${looks[lookNumber].viewport.width}.png`) });
    await page.click("#compare-none");
    await page.locator("#comparison").waitFor({ state: "hidden", timeout: STEP_MS });
    await page.context().close();
  }
}

/// A trial of the archive: its course over those before it, by keyboard; and one that the archive has no onset of.
async function anyTrial(browser, gateway, desk, stops) {
  for (const lookNumber of [0, 5]) {
    gateway.forgetAll();
    desk.enter(named("completed"));
    const page = await openPage(browser, gateway, "archive", looks[lookNumber]);
    const name = `a trial of the archive, ${looks[lookNumber].viewport.width}`;
    await page.locator('[data-trial="2"]').focus({ timeout: STEP_MS });
    await page.keyboard.press("Enter");
    await until(async () => { const seen = await page.textContent("#archived-trial .caption"); return [/^Solid: x; dashed: y\. Faint: the 1 before it\. 12 samples of this trial are missing\. Thick and pale: the fit of state_variable over 8 trials; its residual is \d\.\d{3} N \(RMS\)\.$/.test(seen), seen]; }, `${name}: says what is drawn`);
    const seen = await page.evaluate(() => ({
      head: document.querySelector("#archived-trial-age").textContent,
      titles: Array.from(document.querySelectorAll("#archived-trial svg"), (one) => one.getAttribute("aria-label")),
      courses: Array.from(document.querySelectorAll("#archived-trial svg"), (one) => [one.querySelectorAll(".course").length, one.querySelectorAll(".course.before").length].join(" of which before ")),
      pressed: document.querySelector('[data-trial="2"]').getAttribute("aria-pressed"),
      focus: document.activeElement.dataset.trial,
    }));
    if (seen.head !== "trial 2: reference, rejected: off target: 6.1 mm, at most 5 mm; early reaction") fail(`${name}: names trial and verdict; seen: ${seen.head}`);
    if (seen.titles.join() !== "displacement (mm),force (N),residual (N)") fail(`${name}: units; seen: ${seen.titles}`);
    if (seen.courses.join() !== "4 of which before 2,6 of which before 2,2 of which before 0") fail(`${name}: both axes of both trials, the fit and its residual; seen: ${seen.courses}`);
    const first = await page.locator('#trials tr:first-child td').allTextContents();
    if (first[3] !== "rejected by hand: coughed (Anna)") fail(`${name}: a rejection by hand has its reason; seen: ${first}`);
    const notes = await page.locator("#notes td").allTextContents();
    if (notes.join("; ") !== "11:19:32; 1; light on; Anna") fail(`${name}: notes are listed; seen: ${notes}`);
    for (const [filter, attempts] of [["by-hand", "1"], ["rejected", "1,2"], ["valid", ""], ["all", "1,2"]]) {
      await page.selectOption("#trial-filter", filter);
      const found = await page.locator("#trials button").allTextContents();
      if (found.join() !== attempts) fail(`${name}: trials that are ${filter}; seen: ${found}`);
    }
    await page.locator('[data-trial="2"]').focus();
    if (seen.pressed !== "true" || seen.focus !== "2") fail(`${name}: the trial's button is pressed and keeps the focus; seen: ${seen.pressed}, ${seen.focus}`);
    stops.add(await look(page, name));
    await page.screenshot({ fullPage: true, path: join(screenshots, `archive-trial-${looks[lookNumber].viewport.width}.png`) });
    await page.click('[data-trial="1"]');
    await until(async () => { const said = await page.textContent("#archived-trial .caption"); return [said.includes("there is no such page"), said]; }, `${name}: says why there is nothing to draw`);
    await page.context().close();
  }
}

/// On paper nothing is cut off, and what is only for pressing is left out.
async function print(browser, gateway, desk) {
  gateway.forgetAll();
  desk.enter(named("completed"));
  for (const path of ["results", "archive"]) {
    const page = await openPage(browser, gateway, path, { ...looks[3], viewport: { width: 700, height: 990 } });
    await page.locator("#estimates tr").first().waitFor({ timeout: STEP_MS });
    await page.waitForTimeout(1000);
    await page.emulateMedia({ media: "print" });
    const seen = await page.evaluate(() => ({
      cut: Array.from(document.querySelectorAll("main :not(.unseen)")).filter((one) => one.clientHeight > 0 && one.scrollHeight > one.clientHeight + 1 && getComputedStyle(one).overflowY !== "visible").map((one) => one.id || one.className),
      wide: document.documentElement.scrollWidth - innerWidth,
      buttons: Array.from(document.querySelectorAll("button")).filter((one) => one.getClientRects().length > 0).length,
      ground: getComputedStyle(document.body).backgroundColor,
    }));
    if (seen.cut.length > 0) fail(`${path} on paper: cut off: ${seen.cut}`);
    if (seen.wide > 0) fail(`${path} on paper: ${seen.wide} px too wide`);
    if (seen.buttons > 0) fail(`${path} on paper: ${seen.buttons} buttons`);
    if (seen.ground !== "rgb(255, 255, 255)") fail(`${path} on paper: the ground is ${seen.ground}`);
    await page.screenshot({ fullPage: true, path: join(screenshots, `print-${path}.png`) });
    await page.context().close();
  }
}

/// What a page loads first, as it would be compressed.
async function load(browser, gateway) {
  for (const path of paths) {
    const page = await (await browser.newContext()).newPage();
    const sizes = [];
    const measure = (response) => {
      if (!new URL(response.url()).pathname.startsWith("/api/")) sizes.push(response.body().then((body) => gzipSync(body).length));
    };
    page.on("response", measure);
    await page.goto(`${gateway.url}/${path}`, { waitUntil: "load" });
    await page.locator("#emergency-stop").waitFor();
    page.off("response", measure);  // one that comes now would be read from a page that is closed
    const bytes = (await Promise.all(sizes)).reduce((sum, size) => sum + size, 0);
    console.log(`${path || "operator"}: first load ${(bytes / 1000).toFixed(1)} kB compressed`);
    if (bytes < 10_000 || bytes > LARGEST_LOAD_BYTES) fail(`${path || "operator"}: first load of ${bytes} bytes`);
    await page.context().close();
  }
}

async function everything(tools, browser, gateway, desk, stops) {
  for (const path of mode === "--scenarios" ? [] : paths) {
    for (const lookNumber of looks.keys()) {
      if (mode !== "--all" && (lookNumber + paths.indexOf(path)) % 3 !== 0) continue;
      gateway.forgetAll();
      await walk(browser, gateway, desk, path, lookNumber, stops);
    }
  }
  await twoOperators(browser, gateway, desk);
  await hangingGateway(browser, gateway, desk);
  await phone(browser, gateway, desk, stops);
  await compareSessions(browser, gateway, desk, stops);
  await anyTrial(browser, gateway, desk, stops);
  for (const scenario of further) await scenario(tools, browser, gateway, desk, stops);
  await print(browser, gateway, desk);
  await load(browser, gateway);
  if (stops.size > 1) fail(`the emergency stop is at one place; seen: ${[...stops].join(" | ")}`);
}

(async () => {
  mkdirSync(screenshots, { recursive: true });
  const gateway = await ScriptedGateway.start({ packages, pages, idl });
  gateway.answers.set("/api/protocols", [{ name: "unloaded", text: 'kind = "unloaded"' }, { name: "cohort", text: 'kind = "study"\nname = "cohort"' }]);
  archive(gateway);
  const desk = new Desk(gateway);
  const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"] });
  const stops = new Set();
  const tools = { openPage, look, until, says, named, looks, screenshots, fail };
  try {
    if (mode !== "--only") await everything(tools, browser, gateway, desk, stops);
    else await (further.find(({ name }) => name === only)?.(tools, browser, gateway, desk, stops) ?? { twoOperators, hangingGateway, phone, compareSessions, anyTrial, print, load }[only](browser, gateway, desk, stops));
  } catch (error) {
    fail(error.stack);
  } finally {
    await browser.close();
    desk.end();
    await gateway.stop();
  }
  console.log(failures.length === 0 ? "all as expected" : `${failures.length} failures`);
  process.exitCode = failures.length === 0 ? 0 : 1;
})();
