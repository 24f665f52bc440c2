// Effect, ghost finger, load, stop: what stands around the plate.
const $ = (id) => document.getElementById(id);

export function controls(link) {
  bind($("ghost-speed"), (value) => link.ask("ghost_speed", { mm_s: value }), (value) => `${value} mm/s`);
  bind($("load"), (value) => link.ask("load", { load_n: value }), (value) => `${value.toFixed(2)} N`);
  $("ghost").onchange = () => link.ask("ghost", { on: $("ghost").checked });
  $("stop").onclick = () => link.ask($("stop").dataset.stopped === "true" ? "go" : "stop");
  $("take").onclick = () => link.ask("take");
  // Nothing moves by itself on a page whose reader asks for less motion.
  let settled = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  link.addEventListener("status", ({ detail }) => {
    if (settled || !detail.drives) return;
    settled = true;
    link.ask("ghost", { on: false });
    link.tell("said", { why: "The ghost finger rests, as your system asks for less motion." });
  });
  addEventListener("keydown", (event) => {
    const armed = document.body.dataset.armed === "true"; // the plate of a device stops whatever has the focus
    if (event.code === "Space" && (armed || !/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName))) {
      event.preventDefault();
      link.ask("stop");
    }
  });
  $("plate").addEventListener("wheel", (event) => {
    event.preventDefault();
    $("load").value = Number($("load").value) - Math.sign(event.deltaY) * 0.05;
    $("load").dispatchEvent(new Event("input"));
  }, { passive: false });
}

export function bind(input, send, told) {
  input.oninput = () => {
    input.nextElementSibling.value = told(Number(input.value));
    send(Number(input.value));
  };
}
