// Seven steps for a reader of the paper; each sets the page up and asks for one thing to try.
const LAW = { "controller.kind": "notch_pi", "controller.feedforward": true }, PI = { "controller.kind": "pi" };
const CALM = { "friction.nominal_n": 0.95, "controller.delay_s": 0.0002, "plate.max_amplitude_um": 2.5, "sensor.noise_density_n_rthz": 2.3e-6 };
const STEPS = [
  ["Friction can be turned down", "Ultrasonic vibration of the glass lowers the friction on a finger: this effect asks for strips of more and less of it. The rings around the finger show the vibration.", "Slide over the strips, and show the amplitudes on the scope.", { effect: "square", values: { ...CALM, ...LAW } }],
  ["But how much, nobody knows beforehand", "Fingers differ, and so do moisture, speed and load. The open loop vibrates as a model says, and this finger has another friction than the model.", "Press Another finger a few times: the open loop misses the wish by another amount each time.", { effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 1.3 } }],
  ["Close the loop", "A sensor measures the force, and the controller corrects the vibration until the force is what was asked for.", "Compare both errors in the table while you slide.", { effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 1.3 } }],
  ["Too much gain", "The paper's gains ring on this bench: plate, sensor and delay answer too late for so much correction.", "Listen to the closed loop, then turn kp of the controller down to 0.06 and ki up to 130.", { effect: "constant", values: { ...CALM, ...PI } }],
  ["Delay", "Each command takes effect some time after its measurement. The later, the less gain the loop bears.", "Turn the controller's delay up, slowly, until the force begins to swing.", { effect: "grating", values: { ...CALM, ...PI, "controller.kp": 0.062, "controller.ki": 134, "controller.delay_s": 0.0005 } }],
  ["Noise and limits", "The plate vibrates by so much and no more, and no loop delivers a friction below that of its full vibration.", "Show the force at full vibration on the scope, and turn the plate's largest amplitude down.", { effect: "square", values: { ...CALM, ...LAW, "plate.max_amplitude_um": 1.2 } }],
  ["Whom it cannot serve", "A finger with little friction cannot be given more of it: vibration only lowers it. The share at its limit says how often the wish is out of reach.", "Draw fingers until you find one that it serves well, and one that it does not.", { effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 0.45 } }],
];

export function touring(link, open, card) {
  let at = -1;
  const title = card.querySelector("h2"), text = card.querySelector(".told"), task = card.querySelector(".task"), count = card.querySelector(".count");
  const [back, next, end] = ["back", "next", "end"].map((name) => card.querySelector(`[data-tour=${name}]`));
  function go(step) {
    at = step;
    card.hidden = at < 0;
    if (card.hidden) { open.focus(); return; }
    const [name, told, asked, { effect, values }] = STEPS[at];
    title.textContent = name;
    text.textContent = told;
    task.textContent = asked;
    count.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    next.textContent = at === STEPS.length - 1 ? "Done" : "Next";
    link.ask("effect", { name: effect });
    link.ask("set", { values });
    title.focus();
  }
  open.onclick = () => go(0);
  back.onclick = () => go(at - 1);
  next.onclick = () => go(at === STEPS.length - 1 ? -1 : at + 1);
  end.onclick = () => go(-1);
}
