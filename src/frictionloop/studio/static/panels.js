import { list } from "./lists.js";

// The loop as the paper draws it: click a box, and its parameters open, as the models describe them.
const BOXES = [
  ["wish", "Wish f_r", "\u2192"], ["controller", "Controller", "\u2192"], ["plate", "Plate", ""],
  ["disturbance", "Disturbance", "\u2192"], ["friction", "Finger and friction", ""], ["sensor", "Sensor", ""],
  ["motion", "Hand", ""], ["board", "Board", ""],
];
// What stands beside the live loop, and what of it counts here.
const BESIDE = {
  motion: "The hand of simulate and sweep. Here you, or the ghost, move the finger: its speed and load are the sliders below the plate. "
    + "On this page only the number of the person counts, for the skin. The rest goes into Share, Python and the command.",
  board: "What the board's electronics are. A simulated loop runs without them. They go into Share, Python and the command, and to a board "
    + "that is set up from the file.",
};
// What goes into each box and comes out of it.
export const BOX_SIGNALS = {
  wish: ["asked_n"],
  controller: ["asked_n", "measured_n", "closed_um"],
  plate: ["closed_um", "open_um"],
  disturbance: ["open_n", "closed_n"],
  friction: ["closed_um", "limit_n", "floor_n", "open_n", "closed_n"],
  sensor: ["closed_n", "measured_n"],
  motion: [],
  board: [],
};
const $ = (id) => document.getElementById(id);

export class Panels {
  constructor(link) {
    Object.assign(this, { link, box: "controller", fields: {} });
    $("diagram").replaceChildren(...BOXES.map(([name, text, arrow]) => {
      const button = document.createElement("button");
      button.setAttribute("role", "tab");
      button.dataset.box = name;
      button.textContent = text;
      if (arrow) button.dataset.arrow = arrow;
      button.classList.toggle("beside", name in BESIDE);
      button.onclick = () => this.open(name);
      return button;
    }));
    link.addEventListener("system", ({ detail }) => { this.told = detail.panels; this.show(); });
    link.addEventListener("refused", () => this.show());
    this.open(this.box);
  }
  open(box) {
    this.box = box;
    this.onopen?.(box);
    for (const button of $("diagram").children) button.setAttribute("aria-selected", button.dataset.box === box);
    this.fields = {};
    $("fields").replaceChildren();
    $("fields").scrollTop = 0;
    $("beside").textContent = BESIDE[box] ?? "";
    $("beside").hidden = !BESIDE[box];
    this.show();
  }
  // A field that is there already only gets its value: a slider in the hand must not be taken away.
  show() {
    const told = this.told?.[this.box] ?? [], paths = told.map((field) => field.path).join();
    if (paths !== Object.keys(this.fields).join()) {
      this.fields = Object.fromEntries(told.map((field) => [field.path, this.made(field)]));
      $("fields").replaceChildren(...Object.values(this.fields).map((field) => field.element));
    }
    for (const field of told) this.fields[field.path].set(field.value);
    // Of a device only controller and effect can change: all else is the bench that stands there.
    $("fields").inert = document.body.dataset.device !== undefined && !["wish", "controller"].includes(this.box);
  }
  send(path, value) {
    this.link.ask("set", { values: { [path]: value } });
  }
  made(told) {
    const field = { ...told, unit: told.unit.replace("um", "\u00b5m").replace("^-2", "\u207b\u00b2").replace("^2", "\u00b2") };
    const element = document.createElement("div"), label = document.createElement("label"), name = document.createElement("span");
    element.className = "field";
    name.textContent = field.name;
    name.title = field.path;
    label.append(name);
    element.append(label);
    const set = "columns" in field ? list(field, label, element, this.link)
      : field.choices ? this.choice(field, label) : this.number(field, label, element);
    if (field.means) {
      const means = document.createElement("p");
      means.textContent = field.means.replaceAll("``", "");
      element.append(means);
    }
    return { element, set };
  }
  choice(field, label) {
    const select = document.createElement("select");
    select.append(...field.choices.map((choice) => new Option(String(choice).replaceAll("_", " "), String(choice))));
    select.onchange = () => this.send(field.path, typeof field.value === "boolean" ? select.value === "true" : select.value);
    label.append(select);
    return (value) => { select.value = String(value); };
  }
  number(field, label, element) {
    const typed = document.createElement("input"), slider = document.createElement("input"), unit = document.createElement("span");
    typed.type = "number";
    typed.step = field.whole ? 1 : "any";
    unit.className = "unit";
    unit.textContent = field.unit;
    slider.type = "range";
    slider.setAttribute("aria-label", field.path);
    Object.assign(slider, { min: field.low, max: field.high, step: field.whole ? 1 : (field.high - field.low) / 400 });
    slider.oninput = () => { typed.value = short(slider.value); this.send(field.path, Number(slider.value)); };
    let known = field.value;
    typed.onblur = () => { typed.value = short(known); }; // what was refused does not stay
    typed.onchange = () => typed.value !== "" && this.send(field.path, Number(typed.value));
    const box = document.createElement("span");
    box.append(typed, " ", unit);
    label.append(box);
    if (field.low === null) typed.placeholder = "left out";
    else element.append(slider);
    return (value) => {
      known = value;
      if (document.activeElement !== slider) slider.value = value;
      if (document.activeElement !== typed) typed.value = short(value);
    };
  }
}

const short = (value) => (value == null ? "" : Number(Number(value).toPrecision(4)));
