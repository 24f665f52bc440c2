// Plays recorded runs with the plate and the scope of the studio; the runs are in the page, or the server has them.
import { Cursors } from "./cursors.js";
import { shareRuns } from "./runs.js";
import { showNumbers } from "./numbers.js";
import { Plate } from "./plate.js";
import { radios } from "./radios.js";
import { Ring } from "./ring.js";
import { Scope } from "./scope.js";
import { legend } from "./signals.js";

const $ = (id) => document.getElementById(id), calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
const plate = new Plate($("plate"));
const HINT = "Drag over the curve to zoom, double-click to return, click for cursors.";
let between = "";
let run = null, ring, scope, at = 0, playing = !calm, before = 0;

const runs = await shareRuns().catch((error) => {
  $("trouble").hidden = false;
  $("trouble").textContent = error.message;
  return [];
});
$("run").replaceChildren(...runs.map((each, number) => new Option(each.name, number)));
if (document.getElementById("runs")) $("live").remove(); // a file of its own has no live page
else $("live").href += location.search;
$("run").hidden = runs.length < 2;
$("run").onchange = () => choose(runs[Number($("run").value)]);

function choose(chosen) {
  run = chosen;
  at = 0;
  $("source").textContent = run.source;
  $("about").textContent = `${run.name}: ${run.about}`;
  $("seek").max = run.rows;
  plate.setMap(run.map ?? { columns: 1, rows: 1, left: -run.plate_mm[0] / 2, right: run.plate_mm[0] / 2, bottom: -30, top: 30, low: 0, high: 0, shares: new Uint8Array(1) });
  ring = new Ring(Object.keys(run.channels), 30, 1 / run.spacing_s);
  if (scope) scope.ring = ring;
  else {
    scope = new Scope($("scope"), ring, run.plate_mm[0]);
    new Cursors(scope, (text) => { between = text; scope.onread?.(""); });
  }
  scope.span = Number($("span").value);
  scope.clearPlaces();
  scope.onread = (text) => { $("cursor").textContent = between || text || HINT; };
  legend($("legend"), () => scope.build());
  if (!playing) seek(Math.round(scope.span / run.spacing_s));
  showNumbers($("numbers"), $("verdict"), {});
  tellPlaying();
}

// Rows up to a number go through the ring as frames of the live page do.
function forward(to) {
  const rows = Math.min(to, run.rows) - at;
  if (rows <= 0) return;
  const channels = run.values.map((values) => values.subarray(at, at + rows));
  const frame = { time: at * run.spacing_s, spacing: run.spacing_s, rows, channels };
  ring.push(frame);
  scope.take(frame);
  at += rows;
  const x = ring.latest("x_mm"), known = (...names) => names.map((name) => ring.latest(name)).find((value) => !Number.isNaN(value)) ?? 0;
  const moved = x - plate.finger.x;
  Object.assign(plate.finger, { x: x || 0, y: run.line_mm, load: ring.latest("load_n") || 0, force: known("closed_n", "open_n", "measured_n"), um: known("closed_um", "open_um") });
  if (Math.abs(moved) > 1e-3) plate.finger.way = Math.sign(moved);
  plate.dirty = true;
  $("seek").value = at;
  $("at").textContent = `${(at * run.spacing_s).toFixed(1)} s`;
  const told = run.numbers[Math.floor((at * run.spacing_s) / run.numbers_s) - 1];
  if (told) showNumbers($("numbers"), $("verdict"), told);
}

function seek(row) {
  ring.clear();
  scope.clearPlaces();
  at = Math.max(0, row - Math.round(10 / run.spacing_s));
  forward(row);
}

function tellPlaying() {
  $("play").textContent = playing ? "Pause" : at >= (run?.rows ?? 0) ? "Again" : "Play";
}

$("play").onclick = () => {
  playing = !playing;
  if (playing && at >= run.rows) seek(0);
  tellPlaying();
};
$("seek").oninput = () => { if (run) seek(Number($("seek").value)); };
$("span").onchange = () => { scope.span = Number($("span").value); scope.dirty = true; };
radios($("axis"), ({ dataset }) => scope?.show(dataset.axis));
addEventListener("keydown", (event) => {
  if (event.code !== "Space" || /^(BUTTON|INPUT|SELECT)$/.test(event.target.tagName)) return;
  event.preventDefault();
  $("play").click();
});

let due = 0;
function draw(now) {
  if (run && playing) {
    due += Number($("pace").value) * Math.min(0.1, (now - before) / 1e3) / run.spacing_s;
    const rows = Math.floor(due);
    due -= rows;
    forward(at + rows);
    if (at >= run.rows) seek(0); // a lab book's page plays on
  }
  before = now;
  plate.draw();
  scope?.draw();
  requestAnimationFrame(draw);
}
if (runs.length) choose(runs[0]);
requestAnimationFrame(draw);
