// The bar of a device: who it is, its state, its ceiling, what was lost, its fault; arm, disarm, clear.
import { say } from "./say.js";
import { SIGNALS, showOnly } from "./signals.js";

const $ = (id) => document.getElementById(id), BEAT_MS = 40;
const STATES = {
  idle: "Idle: the amplitude is 0.", open: "Open: the lookup table alone drives the plate.",
  closed: "Closed: the control law drives the plate.", fault: "Fault: the amplitude is 0 until it is cleared.",
};

export function device(link, scopeOf) {
  let known = false, drives = false;
  $("arm-closed").onclick = () => link.ask("arm", { state: "closed" });
  $("arm-open").onclick = () => link.ask("arm", { state: "open" });
  $("disarm").onclick = () => link.ask("stop");
  $("clear").onclick = () => link.ask("clear");
  addEventListener("keydown", (event) => { if (known && event.key === "Escape") link.ask("stop"); });
  link.addEventListener("status", ({ detail }) => {
    const told = detail.device;
    $("device-card").hidden = !told;
    drives = detail.drives;
    document.body.dataset.armed = Boolean(told && told.armed !== "idle");
    if (!told) { delete document.body.dataset.device; return; }
    if (!known) first(told, scopeOf());
    known = true;
    const fault = told.fault || told.state === "fault";
    say($("device-title"), detail.source === "device" ? told.name : `${detail.source.toUpperCase()}: ${told.name}`);
    say($("device-state"), STATES[told.state] ?? "Its state is not known.");
    $("device-card").dataset.state = fault ? "fault" : told.state;
    for (const state of ["open", "closed"]) {
      $(`arm-${state}`).disabled = !drives || Boolean(fault);
      $(`arm-${state}`).setAttribute("aria-pressed", told.armed === state);
    }
    $("clear").hidden = !fault;
    $("clear").disabled = !drives;
    const lost = told.lost ? `${told.lost} samples lost` : "no sample lost";
    $("device-told").textContent =
      `${told.address} · firmware ${told.revision} · ceiling ${told.ceiling_um.toFixed(2)} µm, kept by the board in every state · ${lost} · space bar or Escape stops`;
    const text = [told.fault && `Fault ${told.fault}.`, told.trouble].filter(Boolean).join(" ");
    $("device-fault").hidden = !text;
    say($("device-fault"), text);
  });
  // Says that the page is there: the plate is switched off when it stops saying so.
  setInterval(() => { if (known && drives) link.ask("here"); }, BEAT_MS);
}

function first(told, scope) {
  document.body.dataset.device = told.has_finger ? "bench" : "board";
  if (!told.has_finger) {
    showOnly(SIGNALS.filter(({ channel, shown }) => shown || channel === "measured_n").map(({ channel }) => channel));
    $("plate-hint").textContent = "The finger on the device is drawn where its sensor says it is.";
    scope?.build();
  } else $("plate-hint").textContent = `Slide on it; the position sensor of this bench reads ${told.reach_mm.toFixed(0)} mm to either side.`;
}
