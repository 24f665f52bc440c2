// Effect, ghost finger, load, stop: what stands around the plate.
const $ = (id) => document.getElementById(id);

export function controls(link) {
  bind($("ghost-speed"), (value) => link.ask("ghost_speed", { mm_s: value }), (value) => `${value} mm/s`);
  bind($("load"), (value) => link.ask("load", { load_n: value }), (value) => `${value.toFixed(2)} N`);
  $("ghost").onchange = () => link.ask("ghost", { on: $("ghost").checked });
  $("stop").onclick = () => link.ask($("stop").dataset.stopped === "true" ? "go" : "stop");
  $("take").onclick = () => link.ask("take");
  addEventListener("keydown", (event) => {
    if (event.code === "Space" && !/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) {
      event.preventDefault();
      link.ask("stop");
    }
  });
  $("plate").addEventListener("wheel", (event) => {
    event.preventDefault();
    $("load").value = Number($("load").value) - Math.sign(event.deltaY) * 0.05;
    $("load").dispatchEvent(new Event("input"));
  }, { passive: false });
  link.addEventListener("hello", ({ detail }) => effects($("effects"), detail.effects, link));
  link.addEventListener("system", ({ detail }) => {
    for (const chip of $("effects").children) {
      const chosen = chip.dataset.effect === detail.effect;
      chip.setAttribute("aria-checked", chosen);
      chip.tabIndex = chosen || (!detail.effect && chip === $("effects").firstChild) ? 0 : -1;
    }
  });
}

function bind(input, send, told) {
  input.oninput = () => {
    input.nextElementSibling.value = told(Number(input.value));
    send(Number(input.value));
  };
}

function effects(element, names, link) {
  element.replaceChildren(...names.map((name) => {
    const chip = document.createElement("button");
    chip.setAttribute("role", "radio");
    chip.setAttribute("aria-checked", "false");
    chip.dataset.effect = name;
    chip.textContent = name;
    chip.onclick = () => link.ask("effect", { name });
    return chip;
  }));
  element.onkeydown = (event) => {
    const way = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!way) return;
    const chips = [...element.children], next = chips[(chips.indexOf(document.activeElement) + way + chips.length) % chips.length];
    next.focus();
    next.click();
    event.preventDefault();
  };
}
