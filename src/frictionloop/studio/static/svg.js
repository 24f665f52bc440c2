// The scope as a drawing that scales: the same curves, axes and legend as on the screen, as SVG.
import { SIGNALS, colour } from "./signals.js";

const WIDTH = 900, HEIGHT = 420, LEFT = 62, RIGHT = 60, TOP = 44, BOTTOM = 48;

export function svgOf({ plot, axis, told }) {
  const shown = SIGNALS.filter((signal) => signal.shown), scale = plot.scales, um = shown.some((signal) => signal.scale === "um");
  const x = (value) => LEFT + ((value - scale.x.min) / (scale.x.max - scale.x.min)) * (WIDTH - LEFT - RIGHT);
  const y = (value, of) => HEIGHT - BOTTOM - ((value - of.min) / (of.max - of.min)) * (HEIGHT - TOP - BOTTOM);
  const parts = [`<rect width="${WIDTH}" height="${HEIGHT}" fill="${colour("--card")}"/>`];
  const text = (at, up, words, more = "") => parts.push(`<text x="${at.toFixed(1)}" y="${up.toFixed(1)}" ${more}>${words}</text>`);
  for (const value of ticks(scale.x)) {
    parts.push(`<path d="M${x(value).toFixed(1)} ${TOP}V${HEIGHT - BOTTOM}" stroke="${colour("--line")}"/>`);
    text(x(value), HEIGHT - BOTTOM + 17, shorter(value), 'text-anchor="middle"');
  }
  for (const value of ticks(scale.y)) {
    parts.push(`<path d="M${LEFT} ${y(value, scale.y).toFixed(1)}H${WIDTH - RIGHT}" stroke="${colour("--line")}"/>`);
    text(LEFT - 8, y(value, scale.y) + 4, shorter(value), 'text-anchor="end"');
  }
  if (um) for (const value of ticks(scale.um)) text(WIDTH - RIGHT + 8, y(value, scale.um) + 4, shorter(value));
  text(LEFT + (WIDTH - LEFT - RIGHT) / 2, HEIGHT - 10, axis === "time" ? "time (s)" : "place (mm)", 'text-anchor="middle"');
  text(-HEIGHT / 2, 16, "force (N)", 'text-anchor="middle" transform="rotate(-90)"');
  if (um) text(-HEIGHT / 2, WIDTH - 10, "amplitude (µm)", 'text-anchor="middle" transform="rotate(-90)"');
  parts.push(`<clipPath id="in"><rect x="${LEFT}" y="${TOP}" width="${WIDTH - LEFT - RIGHT}" height="${HEIGHT - TOP - BOTTOM}"/></clipPath><g clip-path="url(#in)">`);
  let legend = LEFT;
  for (const signal of shown) {
    const values = plot.data[SIGNALS.indexOf(signal) + 1], of = scale[signal.scale ?? "y"];
    parts.push(`<path d="${curve(plot.data[0], values, x, (value) => y(value, of))}" ${look(signal)}/>`);
  }
  parts.push("</g>");
  text(LEFT + 6, HEIGHT - BOTTOM - 6, told);
  for (const signal of shown) {
    parts.push(`<path d="M${legend} 22h28" ${look(signal)}/>`);
    text(legend + 34, 26, signal.name);
    legend += 52 + 7 * signal.name.length;
  }
  return `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${HEIGHT}" font-family="system-ui, sans-serif" font-size="12" fill="${colour("--ink")}">${parts.join("\n")}</svg>\n`;
}

function look(signal) {
  return `fill="none" stroke="${colour(signal.colour)}" stroke-width="${signal.width}" stroke-dasharray="${signal.dash.join(" ")}" stroke-linejoin="round"`;
}

// A line that is interrupted where nothing is known.
function curve(xs, values, x, y) {
  let path = "", pen = "M";
  xs.forEach((at, n) => {
    const value = values[n];
    if (value == null) { pen = "M"; return; }
    path += `${pen}${x(at).toFixed(1)} ${y(value).toFixed(1)}`;
    pen = "L";
  });
  return path;
}

function ticks({ min, max }) {
  const rough = (max - min) / 8, ten = 10 ** Math.floor(Math.log10(rough)), step = ten * [1, 2, 5, 10].find((each) => each * ten >= rough);
  const first = Math.ceil(min / step), count = Math.floor(max / step) - first + 1;
  return Array.from({ length: Math.max(0, count) }, (_, n) => (first + n) * step);
}

const shorter = (value) => String(Number(value.toPrecision(6))).replace("-", "\u2212");
