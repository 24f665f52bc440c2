"""
Open loop, closed loop
======================

The display asks for a force and believes that the finger's friction is 0.8 N at rest.
This finger has 0.9 N and varies by itself. Without a sensor (open loop) the error
stays; with one, the loop of the paper removes most of it.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

system = fl.feasible().evolve({"friction.nominal_n": 0.9})
print(f"the controller believes {system.controller.model.nominal_n} N")
closed = fl.simulate(system, duration_s=2.0)

# %%
# Open loop is the lookup table alone: the amplitude that would give the wanted force
# if the belief were right.
believed = fl.Friction(nominal_n=system.controller.model.nominal_n)
plant, amplitude_um = fl.Stepper(system), []
for command_um in fl.amplitude_for(closed.f_r.values, believed):
    amplitude_um.append(plant.amplitude_um)
    plant.tick(command_um)
force_n = fl.friction_force(np.array(amplitude_um), system.friction) + closed.d.values
opened = closed.assign(f_a=("time", force_n))

# %%
figure, axes = plt.subplots(2, sharex=True, sharey=True, figsize=(6.6, 4.2))
runs = {"Open loop": opened, "Closed loop": closed}
for axis, (name, run) in zip(axes, runs.items(), strict=True):
    axis.plot(run.time, run.f_r, "--", color="0.35", label="asked for")
    axis.plot(run.time, run.f_a, label="on the finger")
    r2, error_mn = fl.r2_identity(run), 1e3 * fl.rms_error(run)
    axis.set_title(f"{name}: $R^2$ = {r2:.2f}, rms error {error_mn:.0f} mN")
    axis.set_ylabel("force (N)")
axes[0].legend(loc="upper right", ncols=2)
axes[1].set_xlabel("time (s)")
plt.show()
