"""
Equation (2) and the simulator
==============================

The linear analysis gives the loop's frequency responses exactly for a sampled
controller with a hold and a delay. Here they are measured on the non-linear
simulator, one small sine at a time. The analysis takes the disturbance as linear
between samples; the simulator's sine is smooth, so near half the control rate these
two differ, as they should.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

still = {
    "setpoint": fl.Constant(offset_n=0.4),
    "disturbance": fl.Constant(),
    "sensor.noise_rms_n": 0.0,
}
base = fl.paper().evolve(still | {"controller.kp": 5.0, "controller.ki": 200.0})
loop = fl.linearise(base, force_n=0.4)


def measured(block: str, frequency_hz: float) -> complex:
    """Return the response of f_a to a sine of 1 mN in one block, after 1 s."""
    offset_n = getattr(base, block).offset_n
    sine = fl.Sine(offset_n=offset_n, amplitude_n=1e-3, frequency_hz=frequency_hz)
    run = fl.simulate(base.evolve({block: sine}), duration_s=2.0).isel(
        time=slice(5000, None)
    )
    turn = np.exp(-2j * np.pi * frequency_hz * run.time.values)
    return 2j * np.mean((run.f_a.values - run.f_a.values.mean()) * turn) / 1e-3


# %%
tones_hz = np.array(
    [1, 2, 5, 10, 20, 50, 100, 200, 300, 400, 500, 700, 1000, 1500, 2000.0]
)
curve = loop.frequency_response(np.geomspace(1, 2500, 400))
at_tones = loop.frequency_response(tones_hz)
figure, axis = plt.subplots()
for block, name, label in (
    ("setpoint", "f_a_from_f_r", "set-point to force"),
    ("disturbance", "f_a_from_d", "disturbance to force"),
):
    (drawn,) = axis.loglog(curve.frequency, np.abs(curve[name]), label=label)
    points = np.array([measured(block, f) for f in tones_hz])
    axis.loglog(tones_hz, np.abs(points), "o", color=drawn.get_color())
    apart = np.abs(points - at_tones[name].values)
    low = apart[tones_hz <= 100].max()
    print(f"{label}: apart by {low:.0e} up to 100 Hz, {apart.max():.0e} up to 2 kHz")
axis.set(
    xlabel="frequency (Hz)",
    ylabel="magnitude",
    title="Lines: linear theory. Dots: simulator.",
)
axis.legend()
plt.show()

# %%
# The same object holds the margins.
margins = loop.margins()
print(f"phase margin {margins.phase_margin_deg:.1f} deg")
print(f"gain margin {margins.gain_margin:.2f}")
print(f"bears {1e6 * margins.delay_margin_s:.0f} us more delay")
