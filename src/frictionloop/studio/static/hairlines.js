// A curve of any width as hairlines side by side. A browser that draws without a graphics card strokes a wide line of
// a thousand points in several milliseconds, and hairlines (one pixel of the screen) in a tenth of one.
import uPlot from "./vendor/uPlot.esm.js";

const line = uPlot.paths.linear();

// Where the middles of hairlines lie that fill a round pen, in pixels of the screen: in rings, about a pixel apart.
export function pen(width) {
  const reach = (width - 1) / 2, places = [];
  if (reach < 0.2) return [[0, 0]];
  for (let radius = reach; radius > 0; radius -= 1) {
    const count = Math.max(radius < 0.35 ? 2 : 3, Math.ceil(2 * Math.PI * radius / 1.3));
    for (let n = 0; n < count; n++) places.push([radius * Math.cos(2 * Math.PI * (n + 0.25) / count), radius * Math.sin(2 * Math.PI * (n + 0.25) / count)]);
  }
  return places;
}

// For the `paths` of a series.
export function hairlines(plot, series, from, to) {
  const made = line(plot, series, from, to), ratio = devicePixelRatio || 1, wide = new Path2D();
  if (!made) return made;
  for (const [x, y] of pen(plot.series[series].width * ratio)) wide.addPath(made.stroke, new DOMMatrix([1, 0, 0, 1, x, y]));
  return { ...made, stroke: wide, _width: 1 / ratio };
}
