// Brush and eraser: friction painted over what lies on the plate; it becomes a map when the brush is lifted.
import { bind } from "./controls.js";
import { radios } from "./radios.js";

const $ = (id) => document.getElementById(id), KEY_MM = 2;

export class Painter {
  constructor(canvas, plate, link) {
    Object.assign(this, { canvas, plate, link, grid: null, ground: null, own: [], at: null, down: false, mm: 5, force: 0.6 });
    link.addEventListener("hello", ({ detail }) => Object.assign(this, { pitch: detail.paint.mm, most: detail.paint.most_n, size: detail.plate_mm }));
    // The map that answers a painting is the painting; any other is new ground.
    link.addEventListener("map", ({ detail }) => {
      this.served = detail;
      if (this.grid && this.own.some((grid) => this.alike(grid, this.sampled(detail)))) return;
      this.grid = this.ground = null;
      this.own = [];
    });
    radios($("tools"), ({ dataset }) => this.take(dataset.tool));
    bind($("brush-mm"), (value) => { this.mm = value; plate.dirty = true; }, (value) => `${value} mm`);
    bind($("brush-n"), (value) => { this.force = value; }, (value) => `${value.toFixed(2)} N`);
    $("fill").onclick = () => { this.begin(); this.grid.fill(this.byte()); this.show(); this.send(); };
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerleave", () => { if (!this.down) { this.at = null; plate.dirty = true; } });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => this.lift());
    canvas.addEventListener("keydown", (event) => this.key(event));
    plate.layers.push((g, x, y) => this.brush(g, x, y));
  }
  get active() {
    return Boolean(this.canvas.dataset.tool);
  }
  take(tool) {
    this.canvas.dataset.tool = tool === "slide" ? "" : tool;
    this.plate.showsFinger = !this.active;
    for (const each of document.querySelectorAll("[data-paint]")) each.hidden = !this.active;
    $("brush-n").disabled = $("fill").disabled = tool === "eraser";
    this.at = this.active ? [0, 0] : null;
    this.plate.dirty = true;
  }
  byte() {
    return Math.round(255 * Math.min(1, this.force / this.most));
  }
  begin() {
    if (this.grid) return;
    this.ground = this.sampled(this.plate.map);
    this.grid = this.ground.slice();
  }
  // A map at the places of a painting, in its bytes.
  sampled(map) {
    const [width, height] = this.size, span = map.high - map.low;
    this.columns = Math.floor(width / this.pitch);
    this.rows = Math.floor(height / this.pitch);
    const places = (count, low, high, cells) => Array.from({ length: count }, (_, index) => {
      const mm = (index - (count - 1) / 2) * this.pitch;
      return Math.min(cells - 1, Math.max(0, Math.floor((mm - low) / (high - low) * cells)));
    });
    const across = places(this.columns, map.left, map.right, map.columns), up = places(this.rows, map.bottom, map.top, map.rows);
    const grid = new Uint8Array(this.columns * this.rows);
    up.forEach((from, row) => across.forEach((at, column) => {
      const force = map.low + map.shares[from * map.columns + at] / 255 * span;
      grid[row * this.columns + column] = Math.round(255 * Math.min(1, Math.max(0, force / this.most)));
    }));
    return grid;
  }
  alike(a, b) {
    return a.length === b.length && a.every((byte, at) => Math.abs(byte - b[at]) <= 2);
  }
  press(event) {
    if (!this.active || event.button !== 0) return;
    event.preventDefault();
    this.canvas.setPointerCapture(event.pointerId);
    this.begin();
    this.down = true;
    this.at = this.plate.mm(event.clientX, event.clientY);
    this.dab(...this.at);
    this.show();
  }
  move(event) {
    if (!this.active) return;
    const [x, y] = this.plate.mm(event.clientX, event.clientY), [fromX, fromY] = this.at ?? [x, y];
    this.at = [x, y];
    this.plate.dirty = true;
    if (!this.down) return;
    const steps = Math.max(1, Math.ceil(Math.hypot(x - fromX, y - fromY) / this.pitch));
    for (let step = 1; step <= steps; step++) this.dab(fromX + (x - fromX) * step / steps, fromY + (y - fromY) * step / steps);
    this.show();
  }
  lift() {
    if (!this.down) return;
    this.down = false;
    this.send();
  }
  key(event) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!this.active || !(way || event.key === "Enter")) return;
    event.preventDefault();
    this.at ??= [0, 0];
    if (way) this.at = this.at.map((mm, axis) => Math.max(-this.size[axis] / 2, Math.min(this.size[axis] / 2, mm + KEY_MM * way[axis])));
    else {
      this.begin();
      this.dab(...this.at);
      this.show();
      this.send();
    }
    this.plate.dirty = true;
  }
  dab(x, y) {
    const { columns, rows, pitch, grid } = this, reach = this.mm / 2 / pitch, erases = this.canvas.dataset.tool === "eraser", byte = this.byte();
    const column = x / pitch + (columns - 1) / 2, row = y / pitch + (rows - 1) / 2;
    for (let r = Math.max(0, Math.ceil(row - reach)); r <= Math.min(rows - 1, row + reach); r++) {
      for (let c = Math.max(0, Math.ceil(column - reach)); c <= Math.min(columns - 1, column + reach); c++) {
        const at = r * columns + c;
        if (Math.hypot(r - row, c - column) <= reach) grid[at] = erases ? this.ground[at] : byte;
      }
    }
  }
  show() {
    const { columns, rows, pitch, grid, most } = this;
    let low = 255, high = 0;
    for (const byte of grid) [low, high] = [Math.min(low, byte), Math.max(high, byte)];
    const shares = grid.map((byte) => (high > low ? 255 * (byte - low) / (high - low) : 0)), [x, y] = [columns * pitch / 2, rows * pitch / 2];
    this.plate.setMap({ columns, rows, left: -x, right: x, bottom: -y, top: y, low: low / 255 * most, high: high / 255 * most, shares });
  }
  async send() {
    this.own = [...this.own.slice(-3), this.grid.slice()];
    try {
      await this.link.bring("paint", { columns: this.columns, rows: this.rows }, this.grid);
    } catch (error) {
      this.grid = this.ground = null;
      this.plate.setMap(this.served);
      this.link.tell("refused", { why: error.message });
    }
  }
  brush(g, x, y) {
    if (!this.active || !this.at) return;
    g.lineWidth = 2;
    for (const [ink, dash] of [["#ffffff", []], ["#17212b", [4, 3]]]) {
      g.strokeStyle = ink;
      g.setLineDash(dash);
      g.beginPath();
      g.arc(x(this.at[0]), y(this.at[1]), this.mm / 2 * this.plate.scale, 0, 2 * Math.PI);
      g.stroke();
    }
    g.setLineDash([]);
  }
}
