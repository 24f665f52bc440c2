// The experimenter's page: progress, the force beside its set-point, what counted and why not; pause, note, abort.
import { Link } from "./link.js";

const $ = (id) => document.getElementById(id), SHOWN = 12;
const link = new Link("experimenter");
let hello = null, live = [], trace = null, state = "running", counted = 0, block = 1, trial = 0, present = 0;

const css = (name) => getComputedStyle(document.body).getPropertyValue(name);
const said = { ready: "waiting for the participant to begin", plain: "measuring the finger by plain strokes", cue: "cue", stroke: "stroke",
  between: "between strokes", answer: "waiting for the answer", break: "break", paused: "paused", feedback: "feedback", end: "over" };

link.addEventListener("hello", ({ detail }) => {
  hello = detail;
  $("source").textContent = detail.source;
  $("blind").hidden = !detail.blind;
  $("title").textContent = `${detail.participant}: ${detail.title || detail.name}`;
  $("force-title").textContent = detail.blind ? "Force beside its set-point" : "Force and set-point";
  $("force-hint").textContent = detail.blind ? "Level, condition and answers are hidden; errors end at 100 mN." : "";
  masked(detail.masking_db);
  head();
});
link.addEventListener("link", ({ detail }) => { $("trouble").hidden = detail.up; $("trouble").textContent = "The connection is lost; this page comes back by itself."; });
link.addEventListener("refused", ({ detail }) => { $("trouble").hidden = false; $("trouble").textContent = detail.why; });
link.addEventListener("pages", ({ detail }) => { present = detail.participant; told(); });
link.addEventListener("status", ({ detail }) => {
  state = detail.state;
  if (detail.why) { $("trouble").hidden = false; $("trouble").textContent = detail.why; }
  told();
});
link.addEventListener("progress", ({ detail }) => { counted = detail.counted; block = detail.block; told(); });
link.addEventListener("step", ({ detail }) => {
  trial = detail.trial;
  if (detail.what === "stroke") { live = []; trace = null; }
  $("step").textContent = said[detail.what] ?? detail.what;
});
link.addEventListener("live", ({ detail }) => { live.push(detail); if (live.length > 2000) live.shift(); });
link.addEventListener("trace", ({ detail }) => { trace = detail; });
link.addEventListener("masking", ({ detail }) => masked(detail.db));
link.addEventListener("noted", ({ detail }) => {
  const line = document.createElement("li");
  line.textContent = `trial ${detail.trial}: ${detail.text}`;
  $("notes").prepend(line);
});
link.addEventListener("row", ({ detail }) => {
  const cells = [detail.trial, detail.phase, detail.valid ? "valid" : "not valid", detail.reason || "", detail.rt_s === null ? "" : `${detail.rt_s.toFixed(2)} s`];
  if (!hello.blind) cells.push(detail.condition, number(detail.requested), number(detail.delivered), detail.response);
  const line = document.createElement("tr");
  line.className = detail.valid ? "good" : "bad";
  for (const text of cells) line.append(Object.assign(document.createElement("td"), { textContent: text }));
  $("rows").tBodies[0].prepend(line);
  while ($("rows").tBodies[0].rows.length > SHOWN) $("rows").tBodies[0].lastChild.remove();
});

const number = (value) => (value === null ? "" : Number(value).toPrecision(3));

function head() {
  const names = ["trial", "phase", "valid", "why not", "response time"];
  if (!hello.blind) names.push("condition", "requested", "delivered", "answer");
  const line = document.createElement("tr");
  for (const name of names) line.append(Object.assign(document.createElement("th"), { textContent: name, scope: "col" }));
  $("rows").tHead.replaceChildren(line);
  told();
}

function told() {
  if (!hello) return;
  const of = hello.expected, share = of ? Math.min(((block - 1) + counted / of) / hello.blocks, 1) : (block - 1) / hello.blocks;
  $("bar").style.width = `${100 * (state === "over" ? 1 : share)}%`;
  $("counts").textContent = `block ${block} of ${hello.blocks}, ${counted}${of ? ` of ${of}` : ""} trials counted, row ${trial}`;
  $("status").textContent = present ? { running: "running", paused: "paused after this trial", aborting: "ending", over: "the session is over" }[state] : "the participant's page is not connected";
  $("pause").setAttribute("aria-pressed", state === "paused");
  $("pause").textContent = state === "paused" ? "Go on" : "Pause";
  $("pause").disabled = $("stop").disabled = state === "over";
}

function masked(db) {
  $("masking").value = db ?? -61;
  $("masking-told").textContent = db === null ? "off" : `${db} dB`;
}
$("masking").oninput = () => { const db = Number($("masking").value); $("masking-told").textContent = db < -60 ? "off" : `${db} dB`; };
$("masking").onchange = () => { const db = Number($("masking").value); link.ask("masking", { db: db < -60 ? null : db }); };
// The button is what was pressed last, also before the host has said so: else the second press would ask for the first again.
$("pause").onclick = () => {
  state = state === "paused" ? "running" : "paused";
  link.ask(state === "paused" ? "pause" : "go");
  told();
};
$("stop").onclick = () => {
  if ($("stop").dataset.sure) link.ask("abort");
  else { $("stop").dataset.sure = "yes"; $("stop").textContent = "Abort: sure?"; setTimeout(() => { delete $("stop").dataset.sure; $("stop").textContent = "Abort"; }, 4000); }
};
$("note").onsubmit = (event) => {
  event.preventDefault();
  if ($("text").value.trim()) link.ask("note", { text: $("text").value.trim() });
  $("text").value = "";
};

function sized(canvas) {
  const scale = devicePixelRatio, w = canvas.clientWidth, h = canvas.clientHeight, pen = canvas.getContext("2d");
  if (canvas.width !== Math.round(w * scale)) { canvas.width = Math.round(w * scale); canvas.height = Math.round(h * scale); }
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, w, h);
  pen.font = "12px system-ui";
  return { pen, w, h };
}

function curve(pen, points, colour, dash = []) {
  pen.strokeStyle = colour; pen.lineWidth = 1.8; pen.setLineDash(dash); pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.stroke(); pen.setLineDash([]);
}

function force() {
  const { pen, w, h } = sized($("force")), left = 58, bottom = 34, top = 10, right = 14;
  if (!hello) return;
  const blind = hello.blind, seconds = trace?.duration_s ?? (hello.guide.direction === "both" ? 2 : 1) * hello.guide.length_mm / hello.guide.speed_mm_s;
  const names = blind ? ["error_mn"] : ["force_n", "setpoint_n"];
  const lines = names.map((name) => trace ? trace[name].map((v, i, all) => [seconds * i / all.length, v]) : live.map((each) => [each.at_s, each[name]]));
  const values = lines.flat().map(([, v]) => v).filter((v) => v !== null);
  const reach = blind ? 100 : Math.max(1, ...values), low = blind ? -reach : 0;
  const X = (s) => left + (w - left - right) * s / seconds, Y = (v) => h - bottom - (h - bottom - top) * (v - low) / (reach - low);
  pen.fillStyle = css("--soft"); pen.strokeStyle = css("--line"); pen.lineWidth = 1; pen.textAlign = "right"; pen.textBaseline = "middle";
  for (const share of [0, 0.5, 1]) {
    const v = low + share * (reach - low);
    pen.beginPath(); pen.moveTo(left, Y(v)); pen.lineTo(w - right, Y(v)); pen.stroke();
    pen.fillText(blind ? `${v.toFixed(0)} mN` : `${v.toFixed(1)} N`, left - 6, Y(v));
  }
  pen.textAlign = "center"; pen.textBaseline = "top";
  for (let s = 0; s <= seconds + 1e-6; s += 0.5) pen.fillText(`${s.toFixed(1)} s`, Math.min(X(s), w - right - 10), h - bottom + 6);
  pen.save(); pen.beginPath(); pen.rect(left, 0, w - left - right, h - bottom + 1); pen.clip();
  lines.forEach((line, k) => curve(pen, line.filter(([, v]) => v !== null).map(([s, v]) => [X(s), Y(v)]), css(k ? "--asked" : "--closed"), k ? [5, 4] : []));
  pen.restore();
}

function gauge(id, value, [low, high], unit) {
  const { pen, w } = sized($(id)), most = 1.4 * high, X = (v) => 4 + (w - 8) * Math.min(v / most, 1);
  pen.fillStyle = css("--line"); pen.fillRect(4, 8, w - 8, 12);
  pen.fillStyle = css("--measured"); pen.globalAlpha = 0.35; pen.fillRect(X(low), 8, X(high) - X(low), 12); pen.globalAlpha = 1;
  pen.fillStyle = css("--soft"); pen.textBaseline = "top"; pen.textAlign = "center";
  pen.fillText(`${low}`, X(low), 26); pen.fillText(`${high} ${unit}`, X(high), 26);
  if (value == null) return;
  pen.fillStyle = value < low || value > high ? css("--stop") : css("--ink");
  pen.fillRect(X(value) - 2, 3, 4, 22);
}

function draw() {
  force();
  const last = live.at(-1);
  if (hello) { gauge("speed", last?.speed_mm_s, hello.speed_mm_s, "mm/s"); gauge("load", last?.load_n, hello.load_n, "N"); }
  requestAnimationFrame(draw);
}
requestAnimationFrame(draw);
