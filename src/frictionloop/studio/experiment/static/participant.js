// The participant's page: a dot to follow, a question, buttons and keys. The page shows; the device's clock tells the time.
import { Link } from "./link.js";
import { Noise } from "./noise.js";

const $ = (id) => document.getElementById(id);
const link = new Link("participant"), noise = new Noise();
const KEYS = { left: "ArrowLeft", right: "ArrowRight", less: "ArrowDown", more: "ArrowUp", alike: "Enter" };
const MARKS = { ArrowLeft: "←", ArrowRight: "→", ArrowDown: "↓", ArrowUp: "↑", Enter: "Enter" };
const ORDER = ["first", "second"];
let hello = null, step = { what: "ready" }, since = 0, refusable = null;
window.noise = noise;

const keyOf = (choice) => KEYS[choice] ?? choice[0].toLowerCase();

function answer(choice, at_ms) {
  if (step.what !== "answer") return;
  link.ask("answer", { answer: choice, trial: step.trial, ...link.host(at_ms) });
  refusable = step;
  show({ what: "between" });
}

function show(next) {
  step = next;
  since = performance.now();
  const { what } = step;
  const said = {
    ready: "Put your finger on the left end of the plate",
    plain: `Stroke the plate, back and forth, ${step.when === "after" ? "once more" : "as the guide shows"}`,
    cue: "Get ready",
    stroke: hello?.intervals === 2 ? `Follow the dot: ${ORDER[step.interval - 1]} stroke` : "Follow the dot",
    between: " ", answer: hello?.question, break: "Take a break", paused: "One moment, please",
    feedback: step.said, end: "Thank you. This is the end.",
  }[what];
  $("said").textContent = said ?? "Please wait";
  $("more").textContent = { ready: "Press Begin, or the space bar, when you are ready.", break: "Press Go on, or the space bar, when you are ready.", cue: "Finger on the left end." }[what] ?? " ";
  $("go").hidden = !["ready", "break"].includes(what);
  $("go").textContent = what === "break" ? "Go on" : "Begin";
  const asks = what === "answer";
  $("answers").hidden = !hello?.choices.length || ["ready", "break", "paused", "plain", "end"].includes(what);
  for (const button of $("answers").children) button.disabled = !asks;
  $("number").hidden = !asks || hello.choices.length > 0;
  if (!$("number").hidden) { $("value").value = ""; $("value").focus(); }
  document.body.dataset.step = what;
}

function sounds() {
  $("sound").textContent = hello?.masking_db == null ? "" : `Masking noise: ${String(hello.masking_db).replace("-", "\u2212")} dB under full scale, on headphones`;
}

link.addEventListener("hello", ({ detail }) => {
  hello = detail;
  noise.set(detail.masking_db);
  sounds();
  $("answers").replaceChildren(...detail.choices.map((choice) => {
    const button = document.createElement("button"), key = document.createElement("kbd"), mark = MARKS[keyOf(choice)] ?? keyOf(choice).toUpperCase();
    button.textContent = choice === "1" ? "First" : choice === "2" ? "Second" : choice[0].toUpperCase() + choice.slice(1);
    key.textContent = mark;
    button.append(key);
    button.dataset.choice = choice;
    button.onclick = (event) => answer(choice, event.timeStamp);
    return button;
  }));
  show(step);
});
link.addEventListener("masking", ({ detail }) => { if (hello) hello.masking_db = detail.db; noise.set(detail.db); sounds(); });
link.addEventListener("step", ({ detail }) => { refusable = null; show(detail); });
link.addEventListener("refused", ({ detail }) => {
  if (!refusable || step.what !== "between") return;
  show(refusable);
  $("more").textContent = detail.why;
});
link.addEventListener("link", ({ detail }) => { $("lost").hidden = detail.up; });
$("go").onclick = () => { noise.begin(); link.ask("ready"); };
$("number").onsubmit = (event) => {
  event.preventDefault();
  const value = $("value").value.trim().replace(",", ".");
  if (value && Number.isFinite(Number(value))) answer(value, event.timeStamp);
};
addEventListener("keydown", (event) => {
  // A key that is held is one answer at most; on a button or in the form its repetitions would press again.
  if (event.repeat && (event.target !== $("value") || event.key === "Enter")) event.preventDefault();
  if (event.repeat || event.target === $("value")) return;
  if (event.key === " " && !$("go").hidden) { event.preventDefault(); $("go").click(); return; }
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const choice = hello?.choices.find((each) => keyOf(each) === key);
  if (choice) { event.preventDefault(); answer(choice, event.timeStamp); }
});

// The guide: a dot that goes along the plate as fast as the finger is to go.
const canvas = $("guide"), pen = canvas.getContext("2d");
function draw(now) {
  requestAnimationFrame(draw);
  const styles = getComputedStyle(document.body), colour = (name) => styles.getPropertyValue(name);
  const scale = devicePixelRatio, w = canvas.clientWidth, h = canvas.clientHeight;
  if (canvas.width !== Math.round(w * scale)) { canvas.width = Math.round(w * scale); canvas.height = Math.round(h * scale); }
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, w, h);
  if (!hello || !["stroke", "cue", "ready", "plain"].includes(step.what)) return;
  const { direction, length_mm, speed_mm_s } = hello.guide, edge = 60, y = 62;
  const seconds = step.duration_s ?? (direction === "both" ? 2 : 1) * length_mm / speed_mm_s;
  let done = step.what === "stroke" ? Math.min((now - since) / 1e3 / seconds, 1) : 0;
  if (step.what === "plain") done = ((now - since) / 1e3 / seconds) % 1;
  const both = direction === "both" || step.what === "plain";
  const way = both ? 1 - Math.abs(2 * done - 1) : direction === "back" ? 1 - done : done;
  const x = edge + way * (w - 2 * edge);
  pen.lineCap = "round";
  pen.lineWidth = 14; pen.strokeStyle = colour("--line");
  pen.beginPath(); pen.moveTo(edge, y); pen.lineTo(w - edge, y); pen.stroke();
  if (step.what === "stroke") {
    pen.strokeStyle = colour("--accent");
    pen.beginPath(); pen.moveTo(direction === "back" ? w - edge : edge, y); pen.lineTo(x, y); pen.stroke();
  }
  pen.fillStyle = colour("--open");
  pen.beginPath(); pen.arc(x, y, 24, 0, 7); pen.fill();
  pen.fillStyle = colour("--soft"); pen.font = "15px system-ui"; pen.textAlign = "center";
  pen.fillText(`${length_mm} mm at ${speed_mm_s} mm/s`, w / 2, y + 62);
}
requestAnimationFrame(draw);
