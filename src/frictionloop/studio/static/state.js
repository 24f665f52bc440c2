// What the session is doing, in words: who drives, what was lost, what has died.
import { say } from "./say.js";

const $ = (id) => document.getElementById(id);

export function states(link) {
  let up = false, dropped = 0, since = -Infinity;
  link.addEventListener("link", ({ detail }) => {
    up = detail.up;
    if (up) return trouble("");
    $("status").textContent = "";
    trouble(detail.refused
      ? "The studio does not let this page in, or is not running: use the address that it printed."
      : "The connection is lost: the plate is at rest. Trying again.");
  });
  for (const name of ["refused", "said"]) link.addEventListener(name, ({ detail }) => flash(detail.why));
  link.addEventListener("status", ({ detail }) => {
    say($("source"), detail.device && detail.source === "device" ? detail.device.name : detail.source);
    $("source").title = detail.source === "simulated" ? "Nothing here is hardware: plate, finger and sensor are computed." : "";
    const resting = detail.state === "stopped" && !detail.device; // a device is armed again, it does not just go on
    say($("stop"), resting ? "Go" : "Stop");
    $("stop").dataset.stopped = resting;
    $("stop").disabled = resting && !detail.drives;
    $("take").hidden = detail.drives || !detail.may_drive;
    for (const id of ["ghost", "ghost-speed", "load"]) $(id).disabled = !detail.drives;
    $("ghost").checked = detail.ghost;
    if (detail.state === "dead") trouble(`The engine has stopped: ${detail.why}`);
    const parts = [];
    if (detail.state === "stopped") parts.push("The plate is at rest.");
    if (detail.pages) parts.push(detail.drives ? "This page drives" : detail.driven ? "Another page drives" : "Nobody drives");
    const looking = detail.pages - Number(detail.driven);
    if (looking > 0) parts.push(looking === 1 ? "1 page looks on" : `${looking} pages look on`);
    if (detail.dropped_s > dropped + 0.05) [dropped, since] = [detail.dropped_s, performance.now()];
    if (performance.now() - since < 10000) parts.push(`this computer was too slow: ${dropped.toFixed(1)} s were left out`);
    if (!flashing) say($("status"), parts.join(" · "));
  });
}

let flashing = 0;
function flash(text) {
  $("status").textContent = text;
  clearTimeout(flashing);
  flashing = setTimeout(() => { flashing = 0; }, 5000);
}

function trouble(text) {
  $("trouble").hidden = !text;
  say($("trouble"), text);
}
