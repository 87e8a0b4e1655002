// The subject's page: target circle, hand, instruction, and a stop that looks the same at all times. What it shows
// depends on the cue and on the hand's measured place only: not on commands, not on a trial's phase, so that nothing gives
// away when a push comes.

import "./stop.css";
import "./subject.css";
import "./unseen.css";
import { Connection } from "./connection";
import { RigKind, type RigDescription, type SampleBlock, type SessionCue, type TrialProgram } from "./contract";
import { Desk } from "./desk";
import { el, setText } from "./dom";
import { emergencyStop } from "./emergency_stop";
import { Fresh } from "./freshness";
import { handOf, poseOf, robotFrame, type ShoulderPose } from "./geometry";
import { isActive } from "./names";
import { english, subjectLineOf, textsProblem, type SubjectTexts } from "./subject_lines";

const OLD_CURSOR_S = 0.5;
const ZOOM_KEY = "tonus-subject-pixels-per-cm";
const LANGUAGE_KEY = "tonus-subject-language";
const languages = ["en", "de"]; // public/languages; another one by its file's name: /subject?language=fr

const connection = new Connection();
const desk = new Desk(connection);
const session = desk.session;
const cue = new Fresh<SessionCue>();
const samples = new Fresh<SampleBlock>();
let rig: RigDescription | undefined;
let pose: ShoulderPose | undefined;
let cueWritten = 0n;

const canvas = el("canvas", { id: "target", role: "img", "aria-label": "Target circle and hand" });
const instruction = el("p", { class: "instruction", id: "instruction", role: "status" });
const trouble = el("p", { class: "trouble", id: "trouble", role: "alert" });
const line = el("p", { class: "line", id: "strip-text", role: "status" });
const strip = el("section", { class: "strip", id: "strip", "aria-label": "What to do" }, line);
const language = el("select", { id: "language", "aria-label": "Language" }, ...languages.map((name) => el("option", { value: name, lang: name }, name)));
let texts: SubjectTexts = english;
const zoom = el("input", {
  type: "number", id: "zoom", min: 10, max: 1000, step: 1, "aria-label": "Pixels of this screen for one centimetre of the hand's way",
});
zoom.value = localStorage.getItem(ZOOM_KEY) ?? "120";
zoom.addEventListener("input", () => localStorage.setItem(ZOOM_KEY, zoom.value));
const full = el("button", { type: "button", id: "full-screen" }, "Full screen (F)");
const setup = el("div", { class: "setup" }, el("a", { href: "/" }, "Operator"), el("label", {}, "1 cm = ", zoom, " px"), language, full);
const STOP_SAID_MS = 10000;
let stopSaid = { text: "", at: -Infinity };
const stop = emergencyStop(connection, "EMERGENCY STOP", (text) => {
  stopSaid = { text, at: performance.now() };
  showText();
});
const main = el("main", {}, el("h1", { class: "unseen" }, "Target"), canvas, strip, instruction, trouble);
document.body.append(main, el("header", {}, stop, setup));

function toggleFullScreen(): void {
  if (document.fullscreenElement) void document.exitFullscreen();
  else void document.documentElement.requestFullscreen();
}
full.addEventListener("click", toggleFullScreen);
document.addEventListener("keydown", (event) => {
  if (event.key.toLowerCase() === "f" && event.target !== zoom && !event.ctrlKey && !event.altKey) toggleFullScreen();
});
let quietTimer = 0;
function showSetup(): void {
  setup.classList.remove("quiet");
  clearTimeout(quietTimer);
  quietTimer = window.setTimeout(() => setup.classList.add("quiet"), 4000);
}
document.addEventListener("pointermove", showSetup);
showSetup();

connection.subscribe<SessionCue>("session/cue", (arrival) => {
  if (arrival.writtenNs < cueWritten) return;
  cueWritten = arrival.writtenNs;
  cue.set(arrival);
});
connection.subscribe<RigDescription>("rig/description", ({ value }) => (rig = value));
connection.subscribe<{ program: TrialProgram }>("trial/command", ({ value }) => (pose = poseOf(value.program)));
connection.subscribe<{ program: TrialProgram }>("trial/outcome", ({ value }) => (pose = poseOf(value.program)));
connection.subscribe<SampleBlock>("rig/samples", (arrival) => {
  if (!arrival.value.is_resent) samples.set(arrival);
});

/// The hand from the target in metres of S; none where it is not known now.
function handFromTarget(target: SessionCue): [number, number] | undefined {
  const last = samples.value?.samples.at(-1);
  if (!rig || !last || (samples.age ?? Infinity) > OLD_CURSOR_S) return undefined;
  if (rig.kind !== RigKind.RIG_TWO_LINK) return handOf(rig, robotFrame, last).position;
  if (!pose) return undefined;
  const { position } = handOf(rig, pose, last);
  return [position[0] - target.target_m[0]!, position[1] - target.target_m[1]!];
}

function draw(): void {
  const ratio = devicePixelRatio;
  const [width, height] = [innerWidth, innerHeight];
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d")!;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  const target = cue.value;
  const isGoing = session.value !== undefined && isActive(session.value.phase);
  if (target && isGoing && connection.state === "connected") drawTarget(context, target, width / 2, height / 2);
  requestAnimationFrame(draw);
}

function drawTarget(context: CanvasRenderingContext2D, target: SessionCue, x: number, y: number): void {
  const pixelsPerMetre = 100 * Math.min(1000, Math.max(10, Number(zoom.value) || 120));
  context.lineWidth = 3;
  context.strokeStyle = "#f0f0f0";
  context.beginPath();
  context.arc(x, y, (target.target_diameter_m / 2) * pixelsPerMetre, 0, 2 * Math.PI);
  context.stroke();
  canvas.dataset["diameter"] = String(target.target_diameter_m * pixelsPerMetre);
  const hand = target.shows_cursor ? handFromTarget(target) : undefined;
  canvas.dataset["cursor"] = hand ? hand.map((metre) => metre.toFixed(5)).join(" ") : "";
  if (!hand) return;
  context.fillStyle = "#5cc8ff";
  context.beginPath();
  context.arc(x + hand[0] * pixelsPerMetre, y - hand[1] * pixelsPerMetre, 9, 0, 2 * Math.PI);
  context.fill();
}
requestAnimationFrame(draw);

/// A language is a file: a laboratory adds its own beside the others.
async function loadLanguage(name: string): Promise<void> {
  if (!/^[a-z]{2,3}(-[A-Za-z]{2,4})?$/.test(name)) return;
  try {
    const found: unknown = name === "en" ? english : await (await fetch(`/languages/${name}.json`)).json();
    const problem = textsProblem(found);
    if (problem) throw new Error(problem);
    texts = found as SubjectTexts;
    document.documentElement.lang = name;
    language.value = languages.includes(name) ? name : "";
  } catch (error) {
    console.warn(`language ${name}:`, (error as Error).message);
  }
}
language.addEventListener("change", () => {
  localStorage.setItem(LANGUAGE_KEY, language.value);
  void loadLanguage(language.value);
});
void loadLanguage(new URLSearchParams(location.search).get("language") ?? localStorage.getItem(LANGUAGE_KEY) ?? "en");

function showText(): void {
  const key = subjectLineOf(desk.view());
  strip.dataset["state"] = key;
  setText(line, texts[key]);
  setText(trouble, performance.now() - stopSaid.at < STOP_SAID_MS ? stopSaid.text : "");
  setText(instruction, key === "running" || key === "to_the_circle" ? (cue.value?.instruction ?? "") : "");
}
setInterval(showText, 250);
showText();
