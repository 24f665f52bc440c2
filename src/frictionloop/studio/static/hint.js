// A phone or a game pad that vibrates with the friction's changes: a hint of them, and no friction.
const EVERY_MS = 100, FULL_N = 0.15, SECONDS = 0.03;

export function hinting(link, box) {
  const label = box.closest("label"), pads = () => [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.vibrationActuator);
  const look = () => { label.hidden = !(navigator.vibrate && matchMedia("(pointer: coarse)").matches) && !pads().length; };
  let names = [], slow = null, squares = 0, count = 0, last = 0;
  for (const name of ["gamepadconnected", "gamepaddisconnected"]) addEventListener(name, look);
  look();
  link.addEventListener("hello", ({ detail }) => { names = Object.keys(detail.channels); });
  link.addEventListener("frame", ({ detail }) => {
    if (!box.checked || label.hidden) return;
    for (const force of detail.channels[names.indexOf("closed_n")]) {
      slow ??= force;
      slow += detail.spacing / SECONDS * (force - slow);
      squares += (force - slow) ** 2;
      count++;
    }
    const now = performance.now();
    if (now - last < EVERY_MS) return;
    shake(Math.min(1, Math.sqrt(2 * squares / count) / FULL_N));
    [last, squares, count] = [now, 0, 0];
  });
  // A phone knows on and off alone: the share of the time that it is on stands for the strength.
  function shake(strength) {
    const on = Math.round(EVERY_MS * strength);
    if (on > 8) navigator.vibrate?.(on);
    for (const pad of pads()) pad.vibrationActuator.playEffect("dual-rumble", { duration: EVERY_MS, strongMagnitude: strength ** 2, weakMagnitude: strength });
  }
}
