// The library of effects: a small picture of each, all in the same greys.
import { radios } from "./radios.js";
import { colour } from "./signals.js";
import { grey } from "./plate.js";

const $ = (id) => document.getElementById(id);

export function gallery(link) {
  let effects = [], chosen = "", check;
  link.addEventListener("hello", ({ detail }) => {
    effects = detail.effects;
    $("effects").replaceChildren(...effects.map(chip));
    check = radios($("effects"), (button) => link.ask("effect", { name: button.dataset.effect }));
    draw();
    mark();
  });
  link.addEventListener("system", ({ detail }) => { chosen = detail.effect; mark(); });
  addEventListener("look", draw);
  function mark() {
    check?.(document.querySelector(`[data-effect="${CSS.escape(chosen)}"]`));
    $("own-effect").hidden = chosen !== "";
  }
  function draw() {
    effects.forEach(({ name, picture, cells }) => {
      const canvas = document.querySelector(`[data-effect="${CSS.escape(name)}"] canvas`);
      const shares = Uint8Array.from(atob(picture), (letter) => letter.charCodeAt(0));
      [canvas.width, canvas.height] = cells;
      canvas.getContext("2d").putImageData(grey(...cells, shares, colour("--low"), colour("--high")), 0, 0);
    });
  }
}

function chip({ name }) {
  const button = document.createElement("button"), canvas = document.createElement("canvas"), text = document.createElement("span");
  button.setAttribute("role", "radio");
  button.dataset.effect = name;
  canvas.setAttribute("aria-label", `Picture of ${name}`);
  text.textContent = name;
  button.append(canvas, text);
  return button;
}
