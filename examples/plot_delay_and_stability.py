"""
Delay and stability
===================

How much gain a loop bears is a matter of its delay. The map shows the force's
standard deviation in simulation, with constant signals and no noise: dark is at rest,
bright is a limit cycle. The line is the largest stable gain from linear theory,
computed without the simulator. Up to the line a loop that is at rest stays at rest;
but these runs start with a large step, and after one the clamp and the curvature of
the friction law keep a cycle alive already some way below.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import frictionloop as fl

still = {
    "setpoint": fl.Constant(offset_n=0.4),
    "disturbance": fl.Constant(),
    "sensor.noise_rms_n": 0.0,
    "controller.ki": 100.0,
}
quiet = fl.paper().evolve(still)

delays_s, kps = np.linspace(0, 500e-6, 26), np.geomspace(2, 60, 50)
axes = {"controller.delay_s": delays_s, "controller.kp": kps}
grid = fl.sweep(quiet, axes, 1.0, metrics=["output_noise"], score_from_s=0.9)
limits = [
    fl.kp_limit(fl.linearise(quiet.evolve({"controller.delay_s": d}), force_n=0.4))
    for d in delays_s
]

# %%
figure, axis = plt.subplots(figsize=(5.0, 3.2))
deviation_n = grid.output_noise.squeeze("seed").clip(1e-6)
image = axis.pcolormesh(1e6 * delays_s, kps, deviation_n.T, norm=LogNorm(1e-6, 0.3))
axis.plot(1e6 * delays_s, limits, "w--", label="linear theory")
axis.set(yscale="log", xlabel="delay (µs)", ylabel="$K_p$")
axis.set_yticks([2, 5, 10, 20, 50], [2, 5, 10, 20, 50])
axis.minorticks_off()
axis.legend(labelcolor="white")
figure.colorbar(image, label="standard deviation of $f_a$ (N)")
plt.show()


# %%
# Without any delay but the hold: the loop settles at a low gain, then the gain is
# raised to a share of the limit, then one set-point sample is off by 50 mN.
def raised_and_kicked(share: float) -> np.ndarray:
    plant, integral, measured_n = fl.Stepper(quiet), 0.0, []
    low_n, high_n = quiet.controller.model.floor_n, quiet.controller.model.nominal_n
    for k in range(3300):
        kp = limits[0] * (share if k >= 3000 else 0.4)
        e = 0.4 - plant.measured.force + (0.05 if k == 3150 else 0.0)
        v = kp * e + integral
        u = min(max(v, low_n), high_n)
        if not ((v > high_n and e > 0) or (v < low_n and e < 0)):
            integral += 100.0 / 5000 * e
        plant.tick(float(fl.amplitude_for(u, quiet.friction)))
        measured_n.append(plant.measured.force)
    return np.array(measured_n[2950:])


figure, axes = plt.subplots(3, sharex=True, sharey=True, figsize=(6.6, 3.8))
time_ms = np.arange(-50, 300) * 0.2
for axis, share in zip(axes, (0.75, 0.95, 1.05), strict=True):
    axis.plot(time_ms, raised_and_kicked(share), linewidth=0.9)
    axis.set_title(f"$K_p$ = {share * limits[0]:.1f}, {share:.2f} of the limit")
    for when_ms in (0, 30):
        axis.axvline(when_ms, color="0.6", linewidth=0.8)
axes[1].set_ylabel("$f_m$ (N)")
axes[2].set_xlabel("time (ms): gain raised at 0, kick at 30")
plt.show()
