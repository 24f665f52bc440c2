// Twelve fingers that feel the same stroke at once: a picture for each, on one scale; a click takes that finger.
import { LEAST_N, SIGNALS, colour } from "./signals.js";

const PEOPLE = 12, SHOWN_S = 0.8, RATE_HZ = 200, MOST_N = 1.5, EVERY_MS = 30;
const HINT = "People differ. See what each of twelve fingers feels of your stroke, with the loop open and closed.";
const $ = (id) => document.getElementById(id);
const look = Object.fromEntries(SIGNALS.map((signal) => [signal.channel, signal]));

export class Crowd {
  constructor(link) {
    this.size = Math.round(SHOWN_S * RATE_HZ);
    this.rows = Array.from({ length: 1 + 2 * PEOPLE }, () => new Float32Array(this.size));
    Object.assign(this, { link, count: 0, on: false, dirty: false, drawn: 0, frames: 0, next: 0 });
    addEventListener("look", () => { this.dirty = true; });
    this.cells = Array.from({ length: PEOPLE }, (_, number) => this.cell(number));
    $("people").replaceChildren(...this.cells.map((cell) => cell.button));
    $("crowd-on").onclick = () => this.show(!this.on);
    $("finger").onclick = () => this.take(this.next);
    link.addEventListener("hello", () => { if (this.on) link.ask("crowd", { on: true }); });
    link.addEventListener("status", ({ detail }) => { this.beside = detail.source !== "simulated"; });
    link.addEventListener("crowd", ({ detail }) => this.told(detail));
    link.addEventListener("people", ({ detail }) => this.push(detail));
  }
  cell(number) {
    const button = document.createElement("button"), canvas = document.createElement("canvas"), text = document.createElement("span");
    canvas.setAttribute("aria-label", `Forces of finger ${number + 1}`);
    text.textContent = `Finger ${number + 1}`;
    button.append(canvas, text);
    button.onclick = () => this.take(number);
    return { button, canvas, text };
  }
  take(number) {
    this.link.ask("finger", { number });
    this.link.tell("taken", { number });
    this.link.tell("said", { why: `Finger ${number + 1} of the population strokes the plate.` });
    this.next = (number + 1) % 1000;
    $("finger").title = `Finger ${number + 1} of the population is under the plate's stroke`;
    this.cells.forEach((cell, each) => cell.button.toggleAttribute("data-taken", each === number));
  }
  show(on) {
    this.on = on;
    this.count = 0;
    $("people").hidden = !on;
    $("crowd-on").textContent = on ? "Hide" : "Show";
    $("crowd-on").setAttribute("aria-pressed", on);
    $("crowd-told").textContent = on ? "Getting twelve fingers ready …" : HINT;
    this.link.ask("crowd", { on });
  }
  push({ time, spacing, rows, channels }) {
    // What was lost on the way is a gap.
    const lost = this.count ? Math.min(this.size, Math.max(0, Math.round((time - this.until) / spacing) - 1)) : 0;
    for (let row = -lost; row < rows; row++, this.count++) {
      const at = this.count % this.size;
      for (let c = 0; c < channels.length; c++) this.rows[c][at] = row < 0 ? NaN : channels[c][row];
    }
    this.until = time + (rows - 1) * spacing;
    this.dirty = true;
  }
  told({ state, why, people }) {
    if (state !== "making") this.since = undefined;
    else {
      this.since ??= performance.now();
      $("crowd-told").textContent = `Getting twelve fingers ready: their loop is compiled, which is done once, ${((performance.now() - this.since) / 1e3).toFixed(0)} s so far`;
    }
    if (state === "refused") $("crowd-told").textContent = `Twelve fingers cannot be shown with this loop: ${why}`;
    if (state !== "ready") return;
    people.forEach((person, number) => this.name(this.cells[number], person, number));
    const slid = people.filter((person) => person.open_error_n != null);
    if (!slid.length) { $("crowd-told").textContent = "Slide on the plate: all twelve stroke with you."; return; }
    const span = (name) => {
      const errors = slid.map((person) => 1e3 * person[name]);
      return `${Math.min(...errors).toFixed(0)} to ${Math.max(...errors).toFixed(0)} mN`;
    };
    const beyond = slid.filter((person) => person.beyond > 0.3).length;
    $("crowd-told").textContent = `Error with the loop open: ${span("open_error_n")}; closed: ${span("closed_error_n")}.`
      + (beyond ? ` For ${beyond} of them the wish is often out of reach (▲).` : " Everybody is within reach.")
      + ` Each picture: 0 to ${MOST_N} N over ${SHOWN_S} s.${this.beside ? " The row is simulated, beside the device." : ""}`;
  }
  name({ button, text }, person, number) {
    const mn = (value) => (value == null ? "–" : `${(1e3 * value).toFixed(0)}`), beyond = person.beyond > 0.3;
    text.textContent = `${number + 1}: ${mn(person.open_error_n)} → ${mn(person.closed_error_n)} mN${beyond ? " ▲" : ""}`;
    button.setAttribute("aria-label", `Finger ${number + 1}, friction ${person.nominal_n.toFixed(2)} N: error ${mn(person.open_error_n)} mN open, `
      + `${mn(person.closed_error_n)} mN closed${beyond ? ", often out of reach" : ""}. Take this finger.`);
  }
  draw(now) {
    if (!this.on || !this.dirty || now - this.drawn < EVERY_MS) return false;
    this.dirty = false;
    this.drawn = now;
    const ratio = devicePixelRatio || 1, colours = ["--open", "--closed", "--line"].map(colour);
    this.height = this.cells[0].canvas.clientHeight;
    this.cells.forEach(({ canvas }, number) => {
      const width = canvas.clientWidth, size = [width, this.height].map((side) => Math.round(side * ratio));
      if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
      this.picture(canvas.getContext("2d"), width, ratio, number, colours);
    });
    this.frames++;
    return true;
  }
  picture(g, width, ratio, number, [open, closed, line]) {
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, this.height);
    g.strokeStyle = line;
    g.lineWidth = 1;
    g.beginPath();
    g.moveTo(0, this.height - 0.5);
    g.lineTo(width, this.height - 0.5);
    g.stroke();
    this.area(g, width, line);
    this.curve(g, width, this.rows[1 + number], open, look.open_n.width);
    this.curve(g, width, this.rows[1 + PEOPLE + number], closed, look.closed_n.width);
  }
  // The wish as a ground: a dashed line in each of twelve pictures would cost most of the time of a frame.
  area(g, width, fill) {
    g.fillStyle = fill;
    g.beginPath();
    const step = width / this.size;
    this.trace(g, width, this.rows[0], (from, to) => { g.lineTo(to * step, this.height); g.lineTo(from * step, this.height); });
    g.fill();
  }
  curve(g, width, values, stroke, thick) {
    g.strokeStyle = stroke;
    g.lineWidth = thick;
    g.lineJoin = "bevel";
    g.beginPath();
    this.trace(g, width, values);
    g.stroke();
  }
  // Each stretch without a gap is a line of its own; ``close`` is told where it began and ended.
  trace(g, width, values, close = () => {}) {
    const kept = Math.min(this.count, this.size), first = this.count - kept, step = width / this.size;
    let from = null;
    for (let row = 0; row <= kept; row++) {
      const value = row < kept ? values[(first + row) % this.size] : NaN, at = this.size - kept + row;
      if (!(value >= LEAST_N)) {
        if (from !== null) close(from, at - 1);
        from = null;
      } else {
        if (from === null) g.moveTo(at * step, this.height * (1 - value / MOST_N));
        else g.lineTo(at * step, this.height * (1 - value / MOST_N));
        from ??= at;
      }
    }
  }
}
