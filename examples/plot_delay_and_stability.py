"""
Delay and stability
===================

How much gain a loop bears is a matter of its delay. Left, the force's standard deviation in simulation, with constant
signals and no noise: dark is at rest, bright is a limit cycle. The line is the largest stable gain from linear theory,
computed without the simulator. Right, the limit cycle at :math:`K_p = 40` without any delay but the hold.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import frictionloop as fl

still = {"kind": "constant", "offset_n": 0.0}
quiet = fl.paper().evolve({"setpoint": still | {"offset_n": 0.4}, "disturbance": still, "sensor.noise_rms_n": 0.0})

delays_s, kps = np.linspace(0, 500e-6, 26), np.geomspace(2, 60, 50)
grid = fl.sweep(
    quiet, {"controller.delay_s": delays_s, "controller.kp": kps}, 1.0, metrics=["output_noise"], score_from_s=0.8
)
limits = [fl.kp_limit(fl.linearise(quiet.evolve({"controller.delay_s": d}), force_n=0.4)) for d in delays_s]
cycle = fl.simulate(quiet.evolve({"controller.kp": 40.0}), duration_s=1.0).sel(time=slice(0.98, 1.0))

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2))
deviation_n = grid.output_noise.squeeze("seed").clip(1e-6)
image = left.pcolormesh(1e6 * delays_s, kps, deviation_n.T, norm=LogNorm(1e-6, 0.3))
left.plot(1e6 * delays_s, limits, "w--")
left.set(yscale="log", xlabel="delay (µs)", ylabel="$K_p$", title="Stable below the line")
figure.colorbar(image, ax=left, label="standard deviation of $f_a$ (N)")
right.plot(1e3 * (cycle.time - cycle.time[0]), cycle.u, drawstyle="steps-post", color="0.6", label="command $u$")
right.plot(1e3 * (cycle.time - cycle.time[0]), cycle.f_a, label="force $f_a$")
right.set(xlabel="time (ms)", ylabel="force (N)", title="Limit cycle at $K_p$ = 40")
right.legend(loc="upper right", ncols=2)
plt.show()

# %%
# With the period of the cycle in mind (a few control periods), this is not sensor noise: there is none in this run.
crossings = np.flatnonzero(np.diff(np.sign(cycle.f_a.values - float(cycle.f_a.mean()))) > 0)
print(f"period {np.mean(np.diff(crossings)) * 0.2:.2f} ms, largest stable gain {limits[0]:.1f}")
