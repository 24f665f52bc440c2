"""
Your own controller
===================

``Stepper`` is the plant alone, one control period at a time. Here it is driven by a
disturbance observer: predict the force the plate should give, take what is left for
the finger's own variation, and ask for that much less. It is compared with the PI at
a delay of one control period, where the printed gains are unstable. It ends up near
the tuned PI, whose zero cancels the plate's pole: the same idea in another form.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

late = fl.feasible().evolve({"controller.delay_s": 200e-6})
zero_on_pole = {"controller.kp": 2.5, "controller.ki": 2.5 * 2 * np.pi * 100}
printed = fl.simulate(late, duration_s=2.0)
tuned = fl.simulate(late.evolve(zero_on_pole), duration_s=2.0)

# %%
# The observer: ``predicted_n`` is the force the plate should give, ``seen_n`` what
# the sensor should say of it. The command of the period before is used for both,
# since it is the one that acts now. A row of a run holds the values before the
# update, so the amplitude is read before the tick.
dt, model = 1 / late.controller.rate_hz, late.controller.model


def share(cutoff_hz):
    return 1 - np.exp(-2 * np.pi * cutoff_hz * dt)


plant = fl.Stepper(late)
predicted_n = seen_n = u = model.nominal_n
estimate_n, amplitude_um = 0.0, []
for wanted_n in printed.f_r.values:
    amplitude_um.append(plant.amplitude_um)
    left_n = plant.measured.force - seen_n
    estimate_n += share(120.0) * (left_n - estimate_n)
    predicted_n += share(late.plate.cutoff_hz) * (u - predicted_n)
    seen_n += share(late.sensor.cutoff_hz) * (predicted_n - seen_n)
    u = min(max(wanted_n - estimate_n, model.floor_n), model.nominal_n)
    plant.tick(float(fl.amplitude_for(u, late.friction)))

force_n = fl.friction_force(np.array(amplitude_um), late.friction) + printed.d.values
observed = printed.assign(f_a=("time", force_n))

# %%
runs = {
    "PI, printed gains": printed,
    "PI, tuned": tuned,
    "Disturbance observer": observed,
}
figure, axes = plt.subplots(3, sharex=True, sharey=True, figsize=(6.6, 5.0))
for axis, (name, run) in zip(axes, runs.items(), strict=True):
    part = run.sel(time=slice(0.2, 1.2))
    axis.plot(part.time, 1e3 * (part.f_a - part.f_r), linewidth=1.0)
    r2, error_mn = fl.r2_identity(run), 1e3 * fl.rms_error(run)
    axis.set_title(f"{name}: $R^2$ = {r2:.3f}, rms error {error_mn:.0f} mN")
    axis.set_ylabel("error (mN)")
axes[-1].set_xlabel("time (s)")
plt.show()
