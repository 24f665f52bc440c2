// The plate: the effect as a relief of grey, a ruler at true scale, and the finger on it.
import { colour, larger } from "./signals.js";

export const CSS_MM = 96 / 25.4;
const WIDE_MM = 255; // the bench's plate

const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));

// A picture of bytes, the lowest row first, from the colour of least to that of most friction.
export function grey(columns, rows, shares, least, most) {
  const low = rgb(least), high = rgb(most), picture = new ImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const share = shares[(rows - 1 - row) * columns + column] / 255, at = 4 * (row * columns + column);
      for (let c = 0; c < 3; c++) picture.data[at + c] = low[c] + share * (high[c] - low[c]);
      picture.data[at + 3] = 255;
    }
  }
  return picture;
}

export class Plate {
  constructor(canvas) {
    this.canvas = canvas;
    this.scale = Number(localStorage.getItem("px-per-mm")) || Math.max(CSS_MM, canvas.clientWidth / WIDE_MM); // it fills a large screen
    this.centre = 0;
    this.finger = { x: 0, y: 0, load: 0, force: 0, um: 0 };
    this.layers = []; // drawn in every frame
    this.still = []; // { of, draw }: drawn again only when what they are of has become another
    this.kept = {};
    this.stiffness = 1;
    this.dirty = true;
    new ResizeObserver(() => this.resize()).observe(canvas);
    addEventListener("look", () => this.paint());
  }
  resize() {
    const { clientWidth, clientHeight } = this.canvas, ratio = devicePixelRatio || 1;
    this.canvas.width = clientWidth * ratio;
    this.canvas.height = clientHeight * ratio;
    this.ratio = ratio;
    this.dirty = true;
  }
  // Millimetres of a place on the screen, from the middle of the plate; y grows upwards.
  mm(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    return [(clientX - box.left - box.width / 2) / this.scale + this.centre, -(clientY - box.top - box.height / 2) / this.scale];
  }
  setScale(scale) {
    this.scale = scale;
    localStorage.setItem("px-per-mm", scale);
    this.dirty = true;
  }
  setMap(map) {
    this.map = map;
    this.paint();
  }
  paint() {
    if (!this.map) return;
    const { columns, rows, shares } = this.map;
    const picture = grey(columns, rows, shares, colour("--low"), colour("--high"));
    this.picture = new OffscreenCanvas(columns, rows);
    this.picture.getContext("2d").putImageData(picture, 0, 0);
    this.dirty = true;
  }
  draw() {
    if (!this.dirty) return false;
    this.dirty = false;
    const g = this.canvas.getContext("2d", { alpha: false }), width = this.canvas.width / this.ratio, height = this.canvas.height / this.ratio;
    g.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    const x = (mm) => width / 2 + (mm - this.centre) * this.scale, y = (mm) => height / 2 - mm * this.scale;
    g.drawImage(this.ground(x, y, width, height), 0, 0, width, height);
    for (const layer of this.layers) layer(g, x, y, width, height);
    if (this.showsFinger !== false) this.drawFinger(g, x, y);
    return true;
  }
  // All that lies still, as one picture: the effect, what will not arrive, the ruler.
  ground(x, y, width, height) {
    const size = [this.canvas.width, this.canvas.height], of = [...size, this.scale, this.ratio, this.picture, colour("--ground"), ...this.still.flatMap((each) => each.of())];
    if (this.kept.of?.every((each, at) => each === of[at])) return this.kept.picture;
    const picture = new OffscreenCanvas(...size), g = picture.getContext("2d", { alpha: false });
    g.scale(this.ratio, this.ratio);
    g.fillStyle = colour("--ground");
    g.fillRect(0, 0, width, height);
    if (this.picture) {
      const { left, right, bottom, top } = this.map;
      g.drawImage(this.picture, x(left), y(top), x(right) - x(left), y(bottom) - y(top));
    }
    for (const each of this.still) each.draw(g, x, y, width, height);
    this.ruler(g, x, width, height);
    this.kept = { of, picture };
    return picture;
  }
  ruler(g, x, width, height) {
    g.fillStyle = g.strokeStyle = colour("--ink");
    g.globalAlpha = 0.75;
    g.font = `${11 * larger()}px system-ui`;
    g.textAlign = "center";
    g.lineWidth = 1;
    g.beginPath();
    for (let mm = Math.ceil(this.centre - width / 2 / this.scale); x(mm) < width; mm++) {
      const long = mm % 10 === 0 ? 9 : mm % 5 === 0 ? 6 : 3.5;
      g.moveTo(Math.round(x(mm)) + 0.5, height);
      g.lineTo(Math.round(x(mm)) + 0.5, height - long);
      if (mm % 20 === 0 && x(mm) > 20 && x(mm) < width - 20) g.fillText(mm === 0 ? "0 mm" : mm, x(mm), height - 11 - 2 * larger());
    }
    g.stroke();
    g.globalAlpha = 1;
  }
  // Pad and nail; the contact grows with the load, the skin lags by force over stiffness, rings tell of the vibration.
  drawFinger(g, x, y) {
    const { load, force, um, way } = this.finger, at = x(this.finger.x), up = y(this.finger.y), touching = load > 0.01;
    const pad = 6.5 * this.scale, lag = Math.max(-2.4, Math.min(2.4, force / this.stiffness)) * this.scale * (way || 0);
    if (touching && um > 0.02) {
      g.strokeStyle = colour("--closed");
      for (let ring = 1; ring <= 3; ring++) {
        g.globalAlpha = Math.min(1, um / 2.5) * (0.7 - 0.18 * ring);
        g.lineWidth = 2.2;
        g.beginPath();
        g.ellipse(at, up, pad * (0.95 + 0.24 * ring), pad * (1.2 + 0.24 * ring), 0, 0, 2 * Math.PI);
        g.stroke();
      }
    }
    g.globalAlpha = touching ? 0.9 : 0.35;
    g.fillStyle = "#e8b796";
    g.strokeStyle = "#8a5a3c";
    g.lineWidth = 1.5;
    g.beginPath();
    g.ellipse(at, up, pad, pad * 1.3, 0, 0, 2 * Math.PI);
    g.fill();
    g.stroke();
    if (touching) {
      const contact = Math.min(0.95 * pad, this.scale * 3.6 * Math.cbrt(load / 0.5)); // no wider than the pad
      g.fillStyle = "#b56b45";
      g.globalAlpha = 0.85;
      g.beginPath();
      g.ellipse(at - lag, up, contact, contact * 1.25, 0, 0, 2 * Math.PI);
      g.fill();
      g.strokeStyle = "#ffffff";
      g.lineWidth = 2;
      g.beginPath();
      g.moveTo(at, up);
      g.lineTo(at - lag, up);
      g.stroke();
    }
    g.globalAlpha = 1;
  }
}
