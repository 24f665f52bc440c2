// The scope: forces and amplitudes over time, or over the place of the finger.
import uPlot from "./vendor/uPlot.esm.js";
import { hairlines } from "./hairlines.js";
import { LEAST_N, SIGNALS, colour, larger } from "./signals.js";
import { Trail } from "./trail.js";

const BIN_MM = 0.25, SWINGS_S = 0.1;
const DATA_MS = 100; // the moving picture knows the newest; numbers under a cursor and the scale follow so late

export class Scope {
  constructor(element, ring, plateMm) {
    Object.assign(this, { element, ring, span: 4, axis: "time", paused: false, dirty: true, trail: new Trail(), since: -Infinity, told: "" });
    const bins = Math.round(plateMm / BIN_MM);
    this.half = plateMm / 2;
    this.places = Array.from({ length: bins }, (_, bin) => (bin + 0.5) * BIN_MM - this.half);
    this.clearPlaces();
    this.build();
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(element);
    addEventListener("look", () => this.build());
  }
  clearPlaces() {
    this.byPlace = SIGNALS.map(() => new Array(this.places.length).fill(null));
    this.reach = [Infinity, -Infinity];
    this.bin = null;
  }
  size() {
    return { width: Math.max(200, this.element.clientWidth), height: Math.max(120, this.element.clientHeight) };
  }
  build() {
    this.plot?.destroy();
    const axis = { stroke: colour("--soft"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line"), width: 1 }, font: `${12 * larger()}px system-ui`, labelFont: `bold ${12 * larger()}px system-ui`, labelSize: 18 * larger(), space: 45 * larger() };
    const time = this.axis === "time", size = larger();
    const series = SIGNALS.map((s) => ({
      label: s.name, stroke: colour(s.colour), width: s.width, dash: s.dash, show: s.shown, scale: s.scale ?? "y", spanGaps: !time, points: { show: false }, paths: (...of) => (this.moving ? null : hairlines(...of)),
    }));
    const um = SIGNALS.some((s) => s.scale === "um" && s.shown);
    this.plot = new uPlot({
      ...this.size(),
      scales: { x: { time: false }, y: { range: (_, low, high) => [LEAST_N, Math.max(0.8, stepped(1.08 * high, 0.2))] }, um: { range: (_, low, high) => [0, Math.max(3, stepped(1.08 * high, 1))] } },
      axes: [
        { ...axis, label: time ? "time (s)" : "place (mm)", size: 34 * size },
        { ...axis, label: "force (N)", size: 44 * size },
        { ...axis, scale: "um", side: 1, label: "amplitude (µm)", show: um, grid: { show: false } },
      ],
      cursor: { drag: { x: true, y: false, setScale: true }, points: { size: 7 } },
      legend: { show: false },
      series: [{}, ...series],
      hooks: {
        setCursor: [(plot) => this.read(plot)],
        draw: [(plot) => { if (this.moving) this.trail.draw(plot, this.ring, this.span); this.cut(plot); this.marks?.draw(plot); }],
        setSelect: [(plot) => { if (plot.select.width > 0) this.zoomed = true; }],
      },
    }, this.data(), this.element);
    this.plot.ctx.canvas.setAttribute("aria-label", "Curves of the signals shown");
    this.plot.over.addEventListener("dblclick", () => { this.zoomed = false; this.dirty = true; });
    this.zoomed = false;
    this.dirty = true;
  }
  cut({ ctx, bbox }) {
    const ratio = (devicePixelRatio || 1) * larger();
    ctx.save();
    ctx.fillStyle = colour("--soft");
    ctx.font = `${12 * ratio}px system-ui`;
    [ctx.textAlign, ctx.textBaseline] = ["left", "alphabetic"]; // the axes leave their own
    ctx.fillText(this.told, bbox.left + 6 * ratio, bbox.top + bbox.height - 6 * ratio);
    ctx.restore();
  }
  show(axis) {
    this.axis = axis;
    this.marks?.clear();
    this.build();
  }
  take(frame) {
    const x = frame.channels[this.ring.names.indexOf("x_mm")], load = frame.channels[this.ring.names.indexOf("load_n")];
    if (!(frame.time - this.until < 2 * frame.spacing)) this.bin = null; // something was lost on the way
    this.until = frame.time + (frame.rows - 1) * frame.spacing;
    for (let row = 0; row < frame.rows; row++) {
      if (!(load[row] >= 0.02) || row && x[row] === x[row - 1]) continue;
      const bin = Math.floor((x[row] + this.half) / BIN_MM);
      if (bin < 0 || bin >= this.places.length) continue;
      this.reach = [Math.min(this.reach[0], x[row]), Math.max(this.reach[1], x[row])];
      // A fast finger skips places: what it crossed gets its value too.
      const from = this.bin !== null && Math.abs(bin - this.bin) < 12 ? this.bin : bin, way = Math.sign(bin - from) || 1;
      for (let b = from; b !== bin + way; b += way) {
        SIGNALS.forEach((s, n) => {
          const value = frame.channels[this.ring.names.indexOf(s.channel)][row];
          this.byPlace[n][b] = value < LEAST_N ? null : value;
        });
      }
      this.bin = bin;
    }
    this.dirty = true;
  }
  data() {
    if (this.axis === "place") return [this.places, ...this.byPlace];
    const { now } = this.ring, shown = SIGNALS.filter((s) => s.shown);
    if (!shown.some(({ channel }) => this.ring.latest(channel) < LEAST_N)) this.above = now;
    this.told = now - this.above > SWINGS_S ? "▼ below the axis" : "";
    const stretches = Math.round(this.plot ? this.plot.bbox.width / 2 : 400);
    const [x, ...curves] = this.ring.envelope(shown.map((s) => s.channel), now - this.span, now, stretches, LEAST_N);
    return [x, ...SIGNALS.map((s) => curves[shown.indexOf(s)] ?? [])];
  }
  read(plot) {
    if (plot.cursor.idx == null || plot.cursor.left < 0) return this.onread?.("");
    const at = plot.cursor.idx, unit = this.axis === "time" ? "s" : "mm";
    const values = SIGNALS.flatMap((s, n) => {
      const value = plot.data[n + 1][at];
      return s.shown && value != null ? [`${s.name} ${value.toFixed(3)} ${s.scale === "um" ? "µm" : "N"}`] : [];
    });
    this.onread?.(`${plot.data[0][at]?.toFixed(unit === "s" ? 3 : 2)} ${unit}: ${values.join(", ")}`);
  }
  pause(on) {
    this.paused = on;
    if (on) this.plot.setData(this.data(), false); // all of it, to be looked at
  }
  // Whether the curves are the moving picture; else uPlot draws them, of what there is to be looked at.
  get moving() {
    return this.axis === "time" && !this.paused && !this.zoomed;
  }
  draw() {
    if (!this.dirty || this.paused || this.zoomed) return false;
    this.dirty = false;
    const late = performance.now() - this.since > DATA_MS;
    if (late) this.since = performance.now();
    this.plot.batch(() => {
      if (late || !this.moving) this.plot.setData(this.data(), false);
      const now = this.ring.now, [low, high] = this.reach, place = low < high;
      const x = this.axis === "time" ? { min: now - this.span, max: now } : { min: place ? low - 1 : -40, max: place ? high + 1 : 40 };
      this.plot.setScale("x", x);
    });
    return true;
  }
}

// An axis whose end follows every peak would never stand still.
function stepped(value, step) {
  return step * Math.ceil(value / step);
}
