// A field of rows of numbers, one row on a line: steps in time, sections of a filter, entries of a table.
const LINES = 5;

export function list(field, label, element, link) {
  const typed = document.createElement("textarea"), unit = document.createElement("span");
  unit.className = "unit";
  unit.textContent = field.unit;
  label.append(unit);
  typed.setAttribute("aria-label", `${field.path}, one entry on a line`);
  typed.placeholder = "none; one entry on a line";
  typed.spellcheck = false;
  element.append(typed);
  let known = field.value;
  const put = () => {
    typed.value = known.map((row) => row.join("  ")).join("\n");
    typed.rows = Math.min(Math.max(known.length, 1), LINES);
  };
  typed.onblur = put; // what was refused does not stay
  typed.onchange = () => {
    const rows = typed.value.split("\n").map((line) => line.trim().split(/[\s;]+/).filter(Boolean)).filter((row) => row.length);
    const wide = field.columns?.length, wrong = rows.flat().find((word) => !Number.isFinite(Number(word)));
    if (wrong) return link.tell("refused", { why: `${field.path} = ${wrong}: must be a number, with a decimal point` });
    if (wide && rows.some((row) => row.length !== wide)) {
      return link.tell("refused", { why: `${field.path}: each line must have ${wide === 1 ? "one number" : `${wide} numbers`}` });
    }
    const numbers = rows.map((row) => row.map(Number));
    const columns = field.columns?.map((path, at) => [path, numbers.map((row) => row[at])]);
    link.ask("set", { values: Object.fromEntries(columns ?? [[field.path, numbers]]) });
  };
  return (value) => {
    known = value;
    if (document.activeElement !== typed) put();
  };
}
