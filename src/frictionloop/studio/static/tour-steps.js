// Seven steps for a reader of the paper: what is told, what is asked for, how the page is set up, when it is done.
const LAW = { "controller.kind": "notch_pi", "controller.feedforward": true }, PI = { "controller.kind": "pi" };
// Skin that grows moist while one reads would take the wish out of reach.
const CALM = { "friction.nominal_n": 0.95, "friction.occlusion_ratio": 1, "controller.delay_s": 0.0002, "plate.max_amplitude_um": 2.5, "sensor.noise_density_n_rthz": 2.3e-6 };
const FORCES = ["open_n", "closed_n", "asked_n"];

export const STEPS = [
  {
    title: "Friction can be turned down",
    told: "Ultrasonic vibration of the glass lowers the friction on a finger: this effect asks for strips of more and less of it. Rings around the finger, and the dash-dotted curve, show the vibration: it is strong where the friction is low.",
    task: "Slide over the strips with mouse, finger or arrow keys.",
    effect: "square", values: { ...CALM, ...LAW }, signals: ["closed_n", "asked_n", "closed_um"], box: "plate",
    done: (page) => page.slid,
  },
  {
    title: "But by how much, nobody knows beforehand",
    told: "Fingers differ, and so do moisture, speed and load. The open loop vibrates as a model says, and this finger has more friction than the model believes.",
    task: "Press Another finger three times: the open loop misses the wish by another amount each time.",
    effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 1.3 }, signals: ["open_n", "asked_n"], box: "friction",
    done: (page) => page.fingers >= 3,
  },
  {
    title: "Close the loop",
    told: "A sensor measures the force, and the controller corrects the vibration until the force is what was asked for.",
    task: "Slide, and compare both errors.",
    effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 1.3 }, signals: FORCES, box: "controller", crowd: true,
    done: (page) => page.slid,
  },
  {
    title: "Too much gain",
    told: "The paper's gains ring on this bench: plate, sensor and delay answer too late for so much correction. You see it, and with the sound of the closed loop you hear it.",
    task: "Open Presets, and press Gains that hold.",
    effect: "constant", values: { ...CALM, ...PI, "controller.kp": 10, "controller.ki": 2 }, signals: FORCES, box: "controller",
    done: (page) => page.value("controller.kp") < 1,
  },
  {
    title: "Delay",
    told: "Each command takes effect some time after its measurement. The later, the less gain the loop bears: at half a millisecond these gains are calm, at twice that they swing.",
    task: "Turn the controller's delay up, slowly, until the force begins to swing.",
    effect: "constant", values: { ...CALM, ...PI, "controller.kp": 0.062, "controller.ki": 400, "controller.delay_s": 0.0005 }, signals: FORCES, box: "controller",
    done: (page) => page.value("controller.delay_s") >= 0.001,
  },
  {
    title: "Noise and limits",
    told: "The plate vibrates by so much and no more: no loop delivers a friction below that of its full vibration, the short dashes in grey. What will not arrive is hatched. The sensor's noise sets another limit: with more of it, the gain has to be lower.",
    task: "Turn the plate's largest amplitude up until the hatching of what is out of reach is gone.",
    effect: "square", values: { ...CALM, ...LAW, "plate.max_amplitude_um": 1.6 }, signals: ["closed_n", "asked_n", "floor_n"], box: "plate",
    done: (page) => page.value("plate.max_amplitude_um") > 2 && page.beyond === 0,
  },
  {
    title: "Whom it cannot serve",
    told: "A finger with little friction cannot be given more of it: vibration only lowers it. What it cannot be given is hatched; in the row a triangle marks a finger for whom the wish is often out of reach.",
    task: "In the row of twelve, take a finger that the loop serves well.",
    effect: "grating", values: { ...CALM, ...LAW, "friction.nominal_n": 0.35 }, signals: [...FORCES, "limit_n"], box: "friction", crowd: true,
    done: (page) => page.fingers >= 1,
  },
];
