// The curves over time as a picture that moves on: what has been drawn stays, and a frame adds what is new. To draw four
// seconds of three curves anew in every frame takes most of the time in which the page hears nothing of the force.
import { pen } from "./hairlines.js";
import { SIGNALS, colour } from "./signals.js";

const AHEAD = 8; // pixels kept clear before the newest ones: no wider than the widest pen

export class Trail {
  constructor() {
    this.picture = new OffscreenCanvas(1, 1);
    this.key = [];
  }
  // Bring the picture up to what the ring holds, and lay it over the plot; its right edge is now.
  draw(plot, ring, span) {
    const { ctx, bbox } = plot, ratio = devicePixelRatio || 1, [left, top, width, height] = [bbox.left, bbox.top, bbox.width, bbox.height].map(Math.round);
    if (!(width > 0 && height > 0)) return;
    const shown = SIGNALS.filter((signal) => signal.shown), perRow = width / (span * ring.rate), rows = Math.max(1, Math.ceil(2 / perRow)); // two pixels
    const key = [ring, ring.era, width, height, ratio, span, ...shown.flatMap((signal) => [signal.channel, colour(signal.colour), ...this.limits(plot, signal)])];
    const last = Math.floor(ring.count / rows), first = last - Math.ceil(width / (rows * perRow));
    if (key.length !== this.key.length || key.some((each, at) => each !== this.key[at]) || this.drawn < first) this.begin(key, shown, width + 2 * AHEAD, height, Math.max(first, 0), rows * perRow);
    if (last > this.drawn) this.add(plot, ring, last, rows, perRow, ratio);
    const wide = this.picture.width, from = (((Math.round(ring.count * perRow) - width) % wide) + wide) % wide, part = Math.min(width, wide - from);
    ctx.drawImage(this.picture, from, 0, part, height, left, top, part, height);
    if (part < width) ctx.drawImage(this.picture, 0, 0, width - part, height, left + part, top, width - part, height);
  }
  limits(plot, signal) {
    const { min, max } = plot.scales[signal.scale ?? "y"];
    return [min, max];
  }
  begin(key, shown, width, height, first, perStretch) {
    Object.assign(this.picture, { width, height }); // which clears it
    Object.assign(this, { key, drawn: first, cleared: first * perStretch });
    this.pens = shown.map((signal) => ({ signal, at: null, way: 0 })); // where each pen is, and how far it has come
  }
  // Lowest and highest value of each stretch up to a number, in the order in which they came.
  add(plot, ring, last, rows, perRow, ratio) {
    const g = this.picture.getContext("2d"), wide = this.picture.width, from = this.drawn * rows * perRow, to = last * rows * perRow;
    this.clear(g, to + AHEAD);
    const before = Math.floor(Math.max(from - 2, 0) / wide) * wide, after = Math.floor(to / wide) * wide;
    for (const pen of this.pens) this.stroke(g, pen, this.line(plot, pen, ring, last, rows, perRow), before === after ? [before] : [before, after], ratio);
    this.drawn = last;
  }
  clear(g, to) {
    const wide = this.picture.width;
    for (let from = this.cleared; from < to;) {
      const at = from % wide, part = Math.min(to - from, wide - at);
      g.clearRect(Math.floor(at), 0, Math.ceil(part) + 1, this.picture.height);
      from += part;
    }
    this.cleared = Math.max(this.cleared, to);
  }
  // The new part of a curve: points in pixels since the beginning, and null where nothing is known.
  line(plot, { signal, at }, ring, last, rows, perRow) {
    const values = ring.values[signal.channel], [min, max] = this.limits(plot, signal), high = this.picture.height, points = [at];
    const y = (value) => high * (1 - (value - min) / (max - min));
    for (let stretch = this.drawn; stretch < last; stretch++) {
      let low = Infinity, most = -Infinity, lowAt = 0, mostAt = 0;
      for (let row = stretch * rows; row < (stretch + 1) * rows; row++) {
        const value = values[row % ring.size];
        if (value < min) continue;
        if (value < low) { low = value; lowAt = row; }
        if (value > most) { most = value; mostAt = row; }
      }
      const x = stretch * rows * perRow;
      if (low === Infinity) points.push(null);
      else if (rows === 1) points.push([x, y(low)]);
      else points.push([x, y(lowAt < mostAt ? low : most)], [x + rows * perRow / 2, y(lowAt < mostAt ? most : low)]);
    }
    return points;
  }
  stroke(g, each, points, shifts, ratio) {
    const { signal, way } = each;
    g.strokeStyle = colour(signal.colour);
    g.lineWidth = 1;
    g.setLineDash(signal.dash.map((dash) => dash * ratio));
    g.lineDashOffset = way; // a dash goes on where the part before ended it
    g.beginPath();
    for (const shift of shifts) {
      for (const [right, down] of pen(signal.width * ratio)) {
        points.forEach((point, n) => {
          if (!point) return;
          if (points[n - 1]) g.lineTo(point[0] - shift + right, point[1] + down);
          else g.moveTo(point[0] - shift + right, point[1] + down);
        });
      }
    }
    g.stroke();
    points.forEach((point, n) => { if (point && points[n - 1]) each.way += Math.hypot(point[0] - points[n - 1][0], point[1] - points[n - 1][1]); });
    each.at = points.at(-1);
  }
}
