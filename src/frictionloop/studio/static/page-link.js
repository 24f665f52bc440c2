// The link of a page without a server: the loops run here, and tell the page what a server would.
import { mapOf } from "./maps.js";
import { reasonsOf } from "./page-ahead.js";
import { Twelve } from "./page-crowd.js";
import { Session } from "./page-finger.js";
import { Loops, unpacked } from "./page-loops.js";
import { WINDOW_S, numbersOf } from "./page-numbers.js";

const data = JSON.parse(document.getElementById("bench").textContent), names = Object.keys(data.hello.channels);
const TOLD_MS = 200, EVERY = 5, UNDONE = 100, MOVED_N = 0.02;

export class Link extends EventTarget {
  constructor() {
    super();
    Object.assign(this, { up: false, listens: false, before: [], why: "", past: names.map(() => new Float32Array(WINDOW_S * data.rate)) });
    const dead = (why) => this.tell("status", { state: "dead", why, source: "simulated", drives: false, may_drive: false });
    Loops.open(data).then((loops) => this.begin(loops), (error) => dead(`${error.message}: ${data.more}`));
  }
  tell(name, detail) {
    this.dispatchEvent(Object.assign(new Event(name), { detail }));
  }
  begin(loops) {
    Object.assign(this, { loops, up: true, session: new Session((path) => this.advance(path), data.rate) });
    this.session.ghostOn = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.tell("link", { up: true });
    this.tell("hello", data.hello);
    this.show();
    document.body.dataset.build = loops.build;
    document.getElementById("rates").title = `Computed on this page, to the bits of fl.simulate (${loops.build} fma).`;
    const go = () => { requestAnimationFrame(go); this.step(); };
    go();
    setInterval(() => this.tellBeside(), TOLD_MS);
    // A page that nobody sees rests, and has nothing to make good.
    document.addEventListener("visibilitychange", () => { this.session.begun = NaN; });
  }
  show() {
    const { at } = this.loops, law = data.laws[at.law], values = { ...law.values, "controller.kind": at.law, ...data.fingers[at.finger], ...at.stops };
    const field = (told) => ({ ...told, value: values[told.path] ?? told.value });
    const panels = Object.fromEntries(Object.entries({ ...data.panels, controller: law.panel }).map(([box, fields]) => [box, fields.map(field)]));
    const differs = { ...law.differs, ...data.fingers[at.finger], ...at.stops }, find = at.effect && `fl.rendering.find("${at.effect}")`;
    const python = (value) => JSON.stringify(value).replace(/\btrue\b/g, "True").replace(/\bfalse\b/g, "False").replace(/\bnull\b/g, "None");
    const lines = Object.entries(differs).map(([path, value]) => `    "${path}": ${python(value)},`);
    const flags = Object.entries({ "controller.kind": at.law, ...differs }).filter(([path]) => path !== "setpoint.kind").map(([path, value]) => `--${path} ${value}`);
    this.tell("system", {
      type: "system", effect: at.effect, panels, differs: { ...differs, "setpoint.effect": data.effects[at.effect] },
      python: ["import frictionloop as fl", "", "system = fl.bench().evolve({", ...lines, `    "setpoint.effect": ${find || python(data.effects[""])},`, "})", "run = fl.simulate(system, duration_s=5.0)"].join("\n"),
      command: ["frictionloop studio", ...(at.effect ? [`--effect ${at.effect}`] : []), ...flags].join(" "),
    });
    if (this.shown !== at.effect) {
      this.map = null;
      unpacked(data.maps[at.effect]).then((map) => this.tell("map", this.map = mapOf(map)));
    }
    Object.assign(this, { shown: at.effect, reach: null });
    this.status();
  }
  status() {
    const { stopped, ghostOn, ghost, load, line, dropped } = this.session;
    const state = this.why ? "dead" : stopped ? "stopped" : "running";
    this.tell("status", {
      state, why: this.why, source: "simulated", pages: 0, driven: true, drives: true, may_drive: true, dropped_s: dropped,
      ghost: ghostOn, ghost_mm_s: ghost.speed, load_n: load, line_mm: this.map?.rows > 1 ? 0 : line, device: null,
    });
  }
  advance(path) {
    const rows = this.loops.advance(path), row = this.twelve?.follow(path, this.session.ticks + path.length / 3);
    if (row) this.tell("people", row);
    return rows;
  }
  lookAt(on) {
    this.twelve = null;
    try {
      if (on) this.twelve = new Twelve(this.loops, data);
    } catch (error) {
      this.tell("crowd", { state: "refused", why: error.message });
    }
  }
  tellBeside() {
    const numbers = this.numbers();
    this.tell("numbers", numbers);
    this.status();
    const other = numbers.reach?.some((end, which) => !(Math.abs(end - this.reach?.[which]) < MOVED_N)); // it breathes with the finger's noise
    if (this.ahead && this.map && other) {
      this.reach = numbers.reach;
      this.tell("reach", reasonsOf(this.map, data.steep[this.shown], this.reach));
    }
    if (!this.twelve) return;
    const [x, load] = ["x_mm", "load_n"].map((name) => this.past[names.indexOf(name)]);
    this.tell("crowd", { state: "ready", why: "", people: this.twelve.summary(x, load, this.session.ticks) });
  }
  step() {
    if (this.why) return;
    try {
      for (const block of this.session.step(performance.now() / 1e3)) this.frame(block);
    } catch (error) {
      this.why = error.message;
      this.status();
    }
  }
  frame({ first, rows, reached }) {
    const every = this.listens ? 1 : EVERY, count = rows[0].length / every;
    this.past.forEach((past, channel) => {
      past.copyWithin(0, rows[channel].length);
      past.set(rows[channel], past.length - rows[channel].length);
    });
    const channels = rows.map((row) => Float32Array.from({ length: count }, (_, i) => row[every * i + every - 1]));
    this.tell("frame", { time: (first + every) / data.rate, reached, spacing: every / data.rate, rows: count, channels });
  }
  numbers() {
    return numbersOf(this.past.map((past) => past.slice(-this.session.ticks || past.length)), names, data.rate, data.limits);
  }
  // Answers come later, as from a server: who asks may be in the midst of an answer.
  ask(what, more = {}) {
    if (this.up) queueMicrotask(() => this.obey(what, more));
  }
  obey(what, more) {
    const { session, loops } = this, todo = {
      stop: () => { Object.assign(session, { stopped: true, down: false }); },
      go: () => { session.stopped = false; },
      lift: () => { session.down = false; },
      ghost: () => { session.ghostOn = more.on; },
      ghost_speed: () => { session.ghost.speed = more.mm_s; },
      load: () => { session.load = more.load_n; },
      sound: () => { this.listens = more.on; },
      reach: () => { Object.assign(this, { ahead: more.on, reach: null }); },
      crowd: () => this.lookAt(more.on),
      effect: () => this.choose((at) => { at.effect = more.name; }),
      finger: () => this.choose((at) => {
        at.finger = data.axes.fingers.choices[more.number % data.axes.fingers.choices.length] ?? "";
        for (const path of Object.keys(data.fingers[at.finger])) delete at.stops[path];
      }),
      preset: () => this.set(data.presets[more.name]),
      set: () => this.set(more.values),
      undo: () => { if (this.before.length) this.put(this.before.pop()); },
      tour: () => { if (more.on) this.start = loops.at; else if (this.start) this.put(this.start); },
    };
    todo[what]?.();
    this.status();
  }
  // A value that is no stop of its slider moves to the next one; what the page has no choice of is named.
  set(values) {
    this.choose((at) => {
      const { "controller.kind": law, "setpoint.kind": _, "setpoint.effect": effect, ...rest } = values, lacking = law && !(law in data.laws) ? ["controller.kind"] : [];
      const name = Object.keys(data.effects).find((each) => JSON.stringify(data.effects[each]) === JSON.stringify(effect));
      if (name !== undefined) at.effect = name;
      else if (effect) lacking.push("setpoint.effect");
      if (law in data.laws && law !== at.law) {
        at.law = law;
        at.stops = Object.fromEntries(Object.entries(at.stops).filter(([path]) => !["controller.kp", "controller.ki"].includes(path)));
      }
      const axes = { ...data.axes.stops, ...data.axes.gains[at.law] }, near = (path, value) => axes[path].choices.reduce((best, each) => (Math.abs(each - value) < Math.abs(best - value) ? each : best));
      for (const [path, value] of Object.entries({ ...at.stops, ...rest })) {
        if (path in axes) at.stops[path] = near(path, value);
        else if (data.laws[at.law].values[path] !== value) lacking.push(path);
      }
      if (lacking.length) this.tell("refused", { why: `${lacking.join(", ")}: ${data.more}` });
    });
  }
  choose(change) {
    const at = structuredClone(this.loops.at);
    this.before = [...this.before.slice(1 - UNDONE), this.loops.at];
    change(at);
    this.put(at);
  }
  put(at) {
    this.loops.at = at;
    this.loops.change();
    this.twelve?.put(at);
    this.show();
  }
  async bring() {
    throw new Error(data.more);
  }
  touch(events) {
    if (!this.up || !events.length) return;
    const rows = [];
    for (let i = 0; i < events.length; i += 4) rows.push(events.slice(i, i + 4));
    this.session.touch(performance.now() / 1e3, rows);
    this.tell("slid", { events: events.length });
    this.step();
  }
}
