// The page: one link, one past, and what draws it once per animation frame.
import { lookAhead } from "./ahead.js";
import { bringing } from "./bring.js";
import { calibrating } from "./calibrate.js";
import { controls } from "./controls.js";
import { Crowd } from "./crowd.js";
import { Cursors } from "./cursors.js";
import { device } from "./device.js";
import { gallery } from "./gallery.js";
import { hinting } from "./hint.js";
import { Link } from "./link.js";
import { showNumbers } from "./numbers.js";
import { opening } from "./open.js";
import { Painter } from "./paint.js";
import { BOX_SIGNALS, Panels } from "./panels.js";
import { Plate } from "./plate.js";
import { Pointer } from "./pointer.js";
import { presets } from "./presets.js";
import { radios } from "./radios.js";
import { Ring } from "./ring.js";
import { saving } from "./save.js";
import { Scope } from "./scope.js";
import { sharing } from "./share.js";
import { legend, showOnly } from "./signals.js";
import { sounding } from "./sound.js";
import { states } from "./state.js";
import { touring } from "./tour.js";

const $ = (id) => document.getElementById(id), KEPT_S = 30, RATE_HZ = 1000;
const link = new Link(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live${location.search}`);
const plate = new Plate($("plate")), pointer = new Pointer($("plate"), plate, link);
const HINT = "Drag over the curve to zoom, double-click to return, click for cursors.";
let between = "";
let ring, scope;

controls(link);
gallery(link);
presets(link);
lookAhead(plate, link);
new Painter($("plate"), plate, link);
bringing(link);
opening(link);
calibrating(plate);
hinting(link, $("hint"));
states(link);
device(link, () => scope);
sharing(link);
saving(() => scope);
const panels = new Panels(link);
panels.onopen = (box) => legend($("box-signals"), () => scope?.build(), BOX_SIGNALS[box]);
panels.onopen(panels.box);
const crowd = new Crowd(link);
sounding(link, $("sound"));
touring(link, $("tour"), $("tour-card"), (signals, box, people) => {
  showOnly(signals);
  scope?.build();
  panels.open(box);
  if (crowd.on !== people) crowd.show(people);
  $("scope-card")[people ? "before" : "after"]($("crowd-card"));
});
link.addEventListener("hello", ({ detail }) => {
  if (ring) return;
  ring = new Ring(Object.keys(detail.channels), KEPT_S, RATE_HZ);
  scope = new Scope($("scope"), ring, detail.plate_mm[0]);
  if (innerWidth <= 560) $("span").value = 1; // a phone has no room for four strokes of a grating
  scope.span = Number($("span").value);
  scope.onread = (text) => { $("cursor").textContent = between || text || HINT; };
  new Cursors(scope, (text) => { between = text; scope.onread(""); });
  legend($("legend"), () => scope.build());
});
link.addEventListener("map", ({ detail }) => { plate.setMap(detail); scope?.clearPlaces(); });
showNumbers($("numbers"), $("verdict"), {});
link.addEventListener("numbers", ({ detail }) => showNumbers($("numbers"), $("verdict"), detail));
// A device runs one loop at a time, and knows the measured force alone.
const known = (...names) => names.map((name) => ring.latest(name)).find((value) => !Number.isNaN(value)) ?? 0;
const late = [];
let line = 0;
// The skin of this finger, N/mm: how far the contact lags behind.
link.addEventListener("system", ({ detail }) => {
  const skin = detail.panels.friction.find((field) => field.path === "finger.stiffness_n_m");
  plate.stiffness = skin ? skin.value / 1000 : Infinity;
});
link.addEventListener("status", ({ detail }) => { line = detail.line_mm; });
link.addEventListener("frame", ({ detail }) => {
  if (!ring) return;
  ring.push(detail);
  if (!scope.paused) scope.take(detail);
  const before = plate.finger.x, x = ring.latest("x_mm");
  Object.assign(plate.finger, { x: x || 0, y: line, load: ring.latest("load_n"), force: known("closed_n", "open_n", "measured_n"), um: known("closed_um", "open_um") });
  if (Math.abs(x - before) > 1e-3) plate.finger.way = Math.sign(x - before);
  plate.dirty = true;
  const arrived = pointer.arrival(detail.reached);
  if (arrived !== undefined) late.push(performance.now() - arrived - 1000 / 60);
  if (late.length > 240) late.shift();
});
radios($("axis"), ({ dataset }) => scope?.show(dataset.axis));
$("span").onchange = () => { scope.span = Number($("span").value); scope.dirty = true; };
$("pause").onclick = () => {
  scope.pause(!scope.paused);
  $("pause").setAttribute("aria-pressed", scope.paused);
  $("pause").textContent = scope.paused ? "Go on" : "Pause";
};

addEventListener("keydown", (event) => {
  const typing = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) || event.ctrlKey || event.metaKey || event.altKey;
  if (event.key.toLowerCase() === "p" && !typing) $("pause").click();
});

let frames = 0, since = performance.now();
function draw(now) {
  requestAnimationFrame(draw); // first, so that a picture that fails does not hold the finger
  pointer.flush(now);
  plate.draw();
  crowd.draw(now);
  if (scope?.draw()) frames++;
  if (now - since > 1000) {
    const sorted = late.slice().sort((a, b) => a - b), at = (share) => sorted[Math.floor(share * (sorted.length - 1))];
    const told = sorted.length ? `, pointer to force ${at(0.5).toFixed(0)} ms (95 %: ${at(0.95).toFixed(0)} ms) after the 17 ms that the finger follows late` : "";
    $("rates").textContent = `${(1e3 * frames / (now - since)).toFixed(0)} frames/s${told}${crowd.on ? `, twelve fingers ${(1e3 * crowd.frames / (now - since)).toFixed(0)} frames/s` : ""}`;
    frames = crowd.frames = 0;
    since = now;
  }
}
requestAnimationFrame(draw);
