// One button, one picture: the scope as it stands, with its legend, on the page's ground.
import { SIGNALS, colour } from "./signals.js";
import { svgOf } from "./svg.js";

export function saving(scopeOf) {
  for (const id of ["save-csv", "save-h5", "save-toml"]) document.getElementById(id).href += location.search;
  document.getElementById("save-svg").onclick = () => {
    const scope = scopeOf();
    if (!scope) return;
    const link = document.createElement("a"), address = URL.createObjectURL(new Blob([svgOf(scope)], { type: "image/svg+xml" }));
    Object.assign(link, { download: "frictionloop.svg", href: address });
    link.click();
    setTimeout(() => URL.revokeObjectURL(address), 10000);
  };
  document.getElementById("save-png").onclick = () => {
    const scope = scopeOf();
    if (!scope) return;
    const from = scope.plot.ctx.canvas, ratio = devicePixelRatio || 1, head = 34 * ratio;
    const canvas = document.createElement("canvas"), g = canvas.getContext("2d");
    Object.assign(canvas, { width: from.width, height: from.height + head });
    g.fillStyle = colour("--card");
    g.fillRect(0, 0, canvas.width, canvas.height);
    g.drawImage(from, 0, head);
    g.font = `${13 * ratio}px system-ui`;
    let x = 14 * ratio;
    for (const signal of SIGNALS.filter((each) => each.shown)) {
      g.strokeStyle = colour(signal.colour);
      g.lineWidth = (signal.width + 0.6) * ratio;
      g.setLineDash(signal.dash.map((dash) => dash * ratio));
      g.beginPath();
      g.moveTo(x, 18 * ratio);
      g.lineTo(x + 30 * ratio, 18 * ratio);
      g.stroke();
      g.fillStyle = colour("--ink");
      g.fillText(signal.name, x + 36 * ratio, 22 * ratio);
      x += 52 * ratio + g.measureText(signal.name).width;
    }
    const link = document.createElement("a");
    link.download = "frictionloop.png";
    link.href = canvas.toDataURL("image/png");
    link.click();
  };
}
