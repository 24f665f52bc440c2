"""
Your own controller
===================

``Stepper`` is the plant alone, one control period at a time. Here it is driven by a disturbance observer: predict the
force the plate should give, take what is left for the finger's own variation, and ask for that much less. It is
compared with the paper's PI at a delay of one control period, where the printed gains are unstable.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

late = fl.feasible().evolve({"controller.delay_s": 200e-6})
gains = {"PI, printed gains": {"controller.kp": 10.0}, "PI, half of the limit": {"controller.kp": 3.8}}
runs = {name: fl.simulate(late.evolve(changed), duration_s=2.0) for name, changed in gains.items()}
f_r, d = (runs["PI, printed gains"][name].values for name in ("f_r", "d"))

# %%
# The observer in a dozen lines. Row k of a run holds the values before the update at t_k, so the amplitude is
# read before the tick.
dt, model = 1 / late.controller.rate_hz, late.controller.model
plate, sensor, observer = (1 - np.exp(-2 * np.pi * cutoff_hz * dt) for cutoff_hz in (100.0, 1000.0, 40.0))
plant, predicted, seen, estimate_n, amplitude_um, u = fl.Stepper(late), 0.8, 0.8, 0.0, [], 0.8
for wanted in f_r:
    amplitude_um.append(plant.amplitude_um)
    estimate_n += observer * (plant.measured.force - seen - estimate_n)
    predicted += plate * (u - predicted)  # u is still the command of the period before: the delay
    seen += sensor * (predicted - seen)
    u = np.clip(wanted - estimate_n, model.floor_n, model.nominal_n)
    plant.tick(float(fl.amplitude_for(u, late.friction)))
force_n = fl.friction_force(np.array(amplitude_um), late.friction) + d
runs["Disturbance observer"] = runs["PI, printed gains"].assign(f_a=("time", force_n))

# %%
figure, axes = plt.subplots(3, sharex=True, sharey=True, figsize=(6.6, 5.0))
for axis, (name, run) in zip(axes, runs.items(), strict=True):
    part = run.sel(time=slice(0.2, 1.2))
    axis.plot(part.time, 1e3 * (part.f_a - part.f_r), linewidth=1.0)
    axis.set_title(f"{name}: $R^2$ = {fl.r2_identity(run):.3f}, rms {1e3 * fl.rms_error(run):.0f} mN")
    axis.set_ylabel("error (mN)")
axes[-1].set_xlabel("time (s)")
plt.show()
