// Numbers of the last seconds, and one sentence on what they say.
const FORMS = {
  error_n: (value) => `${(1e3 * value).toFixed(0)} mN`,
  felt: (value) => (value < 10 ? value.toFixed(1) : value.toFixed(0)),
  r2: (value) => value.toFixed(2),
  contrast: (value) => `${(100 * value).toFixed(0)} %`,
  saturated: (value) => `${(100 * value).toFixed(0)} %`,
};

export function showNumbers(table, sentence, told) {
  for (const cell of table.querySelectorAll("[data-number]")) {
    const name = cell.dataset.number, value = told[name], form = FORMS[name.replace(/^(open|closed)_/, "")];
    cell.textContent = value == null ? "–" : form(value);
  }
  sentence.textContent = verdict(told);
}

function verdict(told) {
  const { open_error_n: open, closed_error_n: closed, saturated, beyond } = told;
  if (open == null && closed == null) return "Slide on the plate: the numbers begin after a fifth of a second.";
  if (saturated > 0.3 && beyond < 0.3) return "The command runs from limit to limit: the gain is too high for this loop.";
  if (beyond > 0.3) return "The wish is often out of this finger's reach: no controller delivers it there.";
  if (open == null || closed == null) return "One loop runs at a time here: run the other one to compare them.";
  const share = closed / open, unfelt = told.closed_felt != null && told.closed_felt < 1 ? " What is left is below the threshold of touch." : "";
  if (share < 0.8) return `The closed loop leaves ${(100 * share).toFixed(0)} % of the open loop's error.${unfelt}`;
  if (share <= 1.25) return "Open and closed loop err alike here.";
  return "The closed loop makes it worse here: its gains ring, or its model is wrong.";
}
