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
  // As images: a browser looks at each canvas of a page again for every picture that it shows, drawn on or not.
  function draw() {
    const canvas = document.createElement("canvas");
    effects.forEach(({ name, picture, cells }) => {
      const shares = Uint8Array.from(atob(picture), (letter) => letter.charCodeAt(0));
      [canvas.width, canvas.height] = cells;
      canvas.getContext("2d").putImageData(grey(...cells, shares, colour("--low"), colour("--high")), 0, 0);
      document.querySelector(`[data-effect="${CSS.escape(name)}"] img`).src = canvas.toDataURL();
    });
  }
}

function chip({ name }) {
  const button = document.createElement("button"), image = document.createElement("img"), text = document.createElement("span");
  button.setAttribute("role", "radio");
  button.dataset.effect = name;
  image.alt = `Picture of ${name}`;
  text.textContent = name;
  button.append(image, text);
  return button;
}
