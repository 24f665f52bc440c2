// The friction as sound: the force less its slow part, with one loudness for all signals, so that louder means more.
const SECONDS = 0.03, PER_NEWTON = 2.0;
const SOURCES = {
  closed: (row) => row.closed_n, open: (row) => row.open_n, difference: (row) => row.open_n - row.closed_n,
};

export function sounding(link, select) {
  let names = [], port = null, context = null, slow = null;
  link.addEventListener("hello", ({ detail }) => { names = Object.keys(detail.channels); if (port) link.ask("sound", { on: true }); });
  select.onchange = async () => {
    const on = select.value !== "off";
    slow = null;
    if (on && !context) {
      context = new AudioContext();
      await context.audioWorklet.addModule("/static/sound-worklet.js");
      const node = new AudioWorkletNode(context, "friction", { outputChannelCount: [1] });
      node.connect(context.destination);
      port = node.port;
    }
    if (context) await (on ? context.resume() : context.suspend());
    link.ask("sound", { on });
  };
  link.addEventListener("frame", ({ detail }) => {
    if (!port || select.value === "off") return;
    const at = (name) => detail.channels[names.indexOf(name)], open = at("open_n"), closed = at("closed_n");
    const share = detail.spacing / SECONDS, values = new Float32Array(detail.rows);
    for (let row = 0; row < detail.rows; row++) {
      const force = SOURCES[select.value]({ open_n: open[row], closed_n: closed[row] });
      slow ??= force;
      slow += share * (force - slow);
      values[row] = Math.max(-1, Math.min(1, PER_NEWTON * (force - slow)));
    }
    port.postMessage({ rate: 1 / detail.spacing, values });
  });
}
