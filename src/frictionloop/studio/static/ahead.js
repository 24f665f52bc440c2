// What of the effect will not arrive, hatched over the plate: each reason has a hatching of its own.
import { colour } from "./signals.js";

const $ = (id) => document.getElementById(id), GAP = 7;
const REASONS = [
  { bit: 1, name: "beyond", told: "out of this finger's reach", ink: "--stop", lines: [[0, 1, 1, 0]] },
  { bit: 2, name: "steep", told: "steeper than the skin follows", ink: "--ink", lines: [[0, 0, 1, 1], [0, 1, 1, 0]] },
  { bit: 4, name: "weak", told: "too weak to feel (1 to 500 Hz)", ink: "--ink", lines: [[0, 0.5, 1, 0.5]] },
];

export function lookAhead(plate, link) {
  let told = null;
  const box = $("ahead");
  const ask = () => link.ask("reach", { on: box.checked });
  box.onchange = () => { ask(); told = null; say(); plate.dirty = true; };
  link.addEventListener("hello", ask);
  link.addEventListener("system", () => { told = null; say(); plate.dirty = true; });
  link.addEventListener("reach", ({ detail }) => { told = detail; say(); plate.dirty = true; });
  plate.still.push({
    of: () => [told, box.checked, colour("--stop")],
    draw: (g, x, y, width, height) => { if (box.checked && told?.reasons.length) hatch(g, told, x, y, height, plate); },
  });
  function say() {
    const list = $("ahead-told");
    if (!box.checked) list.replaceChildren();
    else if (!told) list.replaceChildren("Looking ahead …");
    else if (told.why) list.replaceChildren(told.why);
    else {
      const there = REASONS.filter(({ name }) => told.shares[name] > 0);
      list.replaceChildren(told.arrives ? `${told.arrives}. ` : "", ...(there.length ? there.map((reason) => key(reason, told.shares[reason.name])) : ["All of it is within reach."]));
    }
  }
}

function hatch(g, told, x, y, height, { scale, ratio, map }) {
  const flat = map?.rows === 1;
  for (const reason of REASONS) {
    g.beginPath();
    told.reasons.forEach((row, number) => {
      const middle = told.bottom_mm + number * told.row_mm, whole = flat && told.reasons.length === 1;
      const top = whole ? 0 : y(middle + told.row_mm / 2), tall = whole ? height : told.row_mm * scale;
      for (const [from, to] of stretches(row, reason.bit)) {
        const left = x(told.from_mm + (from - 0.5) * told.step_mm);
        g.rect(left, top, Math.max(2, x(told.from_mm + (to - 0.5) * told.step_mm) - left), tall);
      }
    });
    g.fillStyle = pattern(g, reason, ratio);
    g.fill();
  }
}

function key({ lines, ink, told }, share) {
  const part = document.createElement("span"), draw = (name) => document.createElementNS("http://www.w3.org/2000/svg", name), svg = draw("svg");
  svg.setAttribute("viewBox", "0 0 14 14");
  svg.setAttribute("aria-hidden", "true");
  for (const shift of [0, GAP]) {
    for (const [x1, y1, x2, y2] of lines) {
      const line = draw("path");
      line.setAttribute("d", `M${GAP * x1 + shift} ${14 * y1}L${GAP * x2 + shift} ${14 * y2}`);
      line.setAttribute("stroke", `var(${ink})`);
      svg.append(line);
    }
  }
  part.className = "key";
  part.append(svg, `${Math.max(1, Math.round(100 * share))} % ${told}`);
  return part;
}

function pattern(g, { lines, ink }, ratio) {
  const size = Math.round(GAP * ratio), tile = new OffscreenCanvas(size, size), t = tile.getContext("2d");
  t.strokeStyle = colour(ink);
  t.lineWidth = 1.4 * ratio;
  t.beginPath();
  for (const [x1, y1, x2, y2] of lines) {
    for (const shift of [-1, 0, 1]) {
      t.moveTo(size * (x1 + shift), size * y1);
      t.lineTo(size * (x2 + shift), size * y2);
    }
  }
  t.stroke();
  const made = g.createPattern(tile, "repeat");
  made.setTransform(new DOMMatrix().scale(1 / ratio));
  return made;
}

// Where a reason holds, from cell to cell.
function stretches(reasons, bit) {
  const found = [];
  reasons.forEach((reason, cell) => {
    if (!(reason & bit)) return;
    if (found.length && found.at(-1)[1] === cell) found.at(-1)[1] = cell + 1;
    else found.push([cell, cell + 1]);
  });
  return found;
}
