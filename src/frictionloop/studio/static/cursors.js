// Two cursors on the scope: a click sets one and then the other, and the line below says what lies between them.
import { SIGNALS, colour } from "./signals.js";

const NAMES = ["A", "B"], FORCE = "N", STEP = 0.005;

export class Cursors {
  constructor(scope, told) {
    Object.assign(this, { scope, told, at: [], next: 0 });
    scope.marks = this;
    scope.build();
    const element = scope.element;
    element.tabIndex = 0;
    element.setAttribute("role", "application");
    element.setAttribute("aria-keyshortcuts", "Enter ArrowLeft ArrowRight Escape");
    element.addEventListener("keydown", (event) => this.press(event));
    element.addEventListener("pointerdown", ({ clientX }) => { this.from = clientX; });
    element.addEventListener("click", (event) => {
      // A drag zooms, a double click returns: only a click that stays sets a cursor.
      if (!event.target.closest(".u-over") || Math.abs(event.clientX - this.from) > 3 || event.detail > 1) return;
      this.set(scope.plot.posToVal(event.clientX - scope.plot.over.getBoundingClientRect().left, "x"));
    });
  }
  set(x) {
    this.at[this.next] = x;
    this.moved = this.next;
    this.next = 1 - this.next;
    this.tell();
  }
  clear() {
    Object.assign(this, { at: [], next: 0, moved: 0 });
    this.tell();
  }
  press(event) {
    const { min, max } = this.scope.plot.scales.x, way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Enter") this.set((min + max) / 2);
    else if (event.key === "Escape") this.clear();
    else if (way && this.at.length) {
      const x = this.at[this.moved] + way * (event.shiftKey ? 10 : 1) * STEP * (max - min);
      this.at[this.moved] = Math.min(max, Math.max(min, x));
      this.tell();
    } else return;
    event.preventDefault();
  }
  values(x) {
    const { data } = this.scope.plot, xs = data[0];
    if (!xs.length) return [];
    let low = 0, high = xs.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= x) low = middle; else high = middle;
    }
    const near = x - xs[low] < xs[high] - x ? low : high;
    return SIGNALS.map((signal, n) => (signal.shown ? data[n + 1][near] : null));
  }
  tell() {
    this.scope.plot.redraw(false);
    const time = this.scope.axis === "time", unit = time ? "s" : "mm", [a, b] = this.at;
    if (a === undefined) return this.told("");
    const place = (x) => `${x.toFixed(time ? 3 : 2)} ${unit}`, here = this.values(a), there = b === undefined ? [] : this.values(b);
    const each = SIGNALS.flatMap((signal, n) => {
      const unitOf = signal.scale === "um" ? "µm" : FORCE;
      if (here[n] == null || (b !== undefined && there[n] == null)) return [];
      return [`${signal.name} ${b === undefined ? here[n].toFixed(3) : signed(there[n] - here[n])} ${unitOf}`];
    });
    if (b === undefined) return this.told(`A ${place(a)}: ${each.join(", ")}. Click again for B.`);
    const way = Math.abs(b - a), rate = time && way ? ` (${(1 / way).toPrecision(3)} Hz)` : "";
    this.told(`A ${place(a)}, B ${place(b)}, apart ${place(way)}${rate}. From A to B: ${each.join(", ")}. Escape removes them.`);
  }
  draw(plot) {
    const { ctx, bbox } = plot, ratio = devicePixelRatio || 1;
    this.at.forEach((x, n) => {
      const left = plot.valToPos(x, "x", true);
      if (!(left >= bbox.left && left <= bbox.left + bbox.width)) return;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = colour("--ink");
      ctx.lineWidth = 1.5 * ratio;
      ctx.setLineDash(n ? [5 * ratio, 3 * ratio] : []);
      ctx.beginPath();
      ctx.moveTo(left, bbox.top);
      ctx.lineTo(left, bbox.top + bbox.height);
      ctx.stroke();
      ctx.font = `600 ${12 * ratio}px system-ui`;
      ctx.fillText(NAMES[n], left + 4 * ratio, bbox.top + 12 * ratio);
      ctx.restore();
    });
  }
}

function signed(value) {
  return `${value < 0 ? "\u2212" : "+"}${Math.abs(value).toFixed(3)}`;
}
