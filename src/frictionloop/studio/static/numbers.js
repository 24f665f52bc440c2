// Numbers of the last seconds, and one sentence on what they say.
import { say } from "./say.js";

const FORMS = {
  error_n: (value) => `${(1e3 * value).toFixed(0)} mN`,
  r2: (value) => value.toFixed(2),
  contrast: (value) => `${(100 * value).toFixed(0)} %`,
  saturated: (value) => `${(100 * value).toFixed(0)} %`,
};

const ROWS = [
  ["error", "error_n"], ["R² to the wish", "r2"], ["contrast given", "contrast"], ["at its limit", ""],
];

// The table is made where it is shown first: the live page and that of recorded runs have the same.
function made(table) {
  const cell = (name) => (name ? `<td data-number="${name}">–</td>` : "<td></td>");
  const row = ([text, name]) => `<tr><th scope="row">${text}</th>${cell(name && `open_${name}`)}${cell(name ? `closed_${name}` : "saturated")}</tr>`;
  table.innerHTML = `<thead><tr><td></td><th scope="col" class="open">open loop</th><th scope="col" class="closed">closed loop</th></tr></thead><tbody>${ROWS.map(row).join("")}</tbody>`;
}

export function showNumbers(table, sentence, told) {
  if (!table.rows.length) made(table);
  for (const cell of table.querySelectorAll("[data-number]")) {
    const name = cell.dataset.number, value = told[name], form = FORMS[name.replace(/^(open|closed)_/, "")];
    say(cell, value == null ? "–" : form(value));
  }
  say(sentence, verdict(told));
}

const percent = (share) => `${(100 * share).toFixed(0)} %`;

function verdict(told) {
  const { open_error_n: open, closed_error_n: closed, saturated, swings, beyond } = told;
  const { device, armed } = document.body.dataset;
  if (device && armed !== "true") return "The plate is off: arm the open or the closed loop.";
  if (open == null && closed == null) return "Slide on the plate: the numbers begin after a fifth of a second.";
  if (saturated > 0.3 && swings > 0.1) return "The command runs from limit to limit: the gain is too high for this loop. Presets have gains that hold.";
  if (beyond > 0.3) return "The wish is often out of this finger's reach: no controller delivers it there.";
  if (open == null || closed == null) return "One loop runs at a time here: run the other one to compare them.";
  const share = closed / open, limited = saturated > 0.3 ? ` For ${percent(saturated)} of the time the plate is at its limit.` : "";
  if (share < 0.8) return `The closed loop leaves ${percent(share)} of the open loop's error.${limited}`;
  if (share <= 1.25) return `Open and closed loop err alike here.${limited}`;
  return "The closed loop makes it worse here: its gains ring, or its model is wrong.";
}
