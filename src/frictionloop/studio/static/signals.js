// What the scope can show: the channel, its name, its look. Told apart by dash and width too, not by colour alone.
export const SIGNALS = [
  { channel: "open_n", name: "open loop", colour: "--open", dash: [], width: 1.1, shown: true },
  { channel: "closed_n", name: "closed loop", colour: "--closed", dash: [], width: 2.2, shown: true },
  { channel: "asked_n", name: "asked for", colour: "--asked", dash: [6, 4], width: 1.6, shown: true },
  { channel: "measured_n", name: "measured", colour: "--measured", dash: [2, 3], width: 1.2, shown: false },
  { channel: "limit_n", name: "without vibration", colour: "--soft", dash: [10, 4], width: 1, shown: false },
  { channel: "floor_n", name: "at full vibration", colour: "--soft", dash: [3, 3], width: 1, shown: false },
  { channel: "closed_um", name: "amplitude closed", colour: "--closed", dash: [8, 3, 2, 3], width: 1.2, shown: false, scale: "um" },
  { channel: "open_um", name: "amplitude open", colour: "--open", dash: [8, 3, 2, 3], width: 1.2, shown: false, scale: "um" },
];

const colours = new Map(); // asked for in every picture, and another only in another look
addEventListener("look", () => colours.clear());
export function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  return colours.get(name);
}

// Less is no friction: at a turn the skin swings over, and its spring is along the motion.
export const LEAST_N = -0.05;

// Letters on a canvas grow with the page: how much larger than on a small screen.
export const larger = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;

// Checkboxes for all signals, or for these channels; each signal has one state, however often it is shown.
export function legend(element, changed, channels) {
  const shown = channels ? SIGNALS.filter(({ channel }) => channels.includes(channel)) : SIGNALS;
  element.replaceChildren(...shown.map((signal) => {
    const label = document.createElement("label"), box = document.createElement("input");
    const line = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    path.setAttribute("d", "M0 5h30");
    path.setAttribute("stroke", `var(${signal.colour})`);
    path.setAttribute("stroke-width", signal.width + 0.6);
    path.setAttribute("stroke-dasharray", signal.dash.join(" "));
    line.append(path);
    box.type = "checkbox";
    box.checked = signal.shown;
    box.dataset.channel = signal.channel;
    box.onchange = () => {
      signal.shown = box.checked;
      for (const same of document.querySelectorAll(`input[data-channel=${signal.channel}]`)) same.checked = box.checked;
      changed();
    };
    label.append(box, line, signal.name);
    return label;
  }));
}

// Show these channels and no others.
export function showOnly(channels) {
  for (const signal of SIGNALS) signal.shown = channels.includes(signal.channel);
  for (const box of document.querySelectorAll("input[data-channel]")) box.checked = channels.includes(box.dataset.channel);
}
