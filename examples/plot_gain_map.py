"""
A map over the gains
====================

1200 runs of 10 s, twice: with the paper's printed signals, and with signals that can
be reached. The first map is flat because its best value is set by what the plate can
do, not by the gains. In the second, fidelity grows with either gain until the loop
turns unstable; the dashed line is that limit from linear theory.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

kps, kis = np.geomspace(1, 60, 40), np.geomspace(0.1, 1000, 30)
gains = {"controller.kp": kps, "controller.ki": kis}
metrics = ["r2_identity", "r2_bound"]
systems = {"Printed signals": fl.paper(), "Reachable signals": fl.feasible()}
maps = {
    name: fl.sweep(system, gains, duration_s=10.0, metrics=metrics)
    for name, system in systems.items()
}

# %%
limits = [fl.kp_limit(fl.paper().evolve({"controller.ki": ki})) for ki in kis]
figure, axes = plt.subplots(1, 2, sharey=True, figsize=(7.2, 3.2))
for axis, (name, grid) in zip(axes, maps.items(), strict=True):
    r2 = grid.r2_identity.squeeze("seed")
    image = axis.pcolormesh(kps, kis, r2.T, vmin=0.2, vmax=1.0)
    axis.plot(limits, kis, "w--", linewidth=1.0)
    axis.plot(10, 2, "o", markerfacecolor="none", markeredgecolor="white")
    axis.text(10, 3, "paper", color="white", ha="center")
    axis.set(xscale="log", yscale="log", xlabel="$K_p$")
    axis.set_title(f"{name}: at most {float(grid.r2_bound.max()):.2f}")
axes[0].set_ylabel("$K_i$ (1/s)")
figure.colorbar(image, ax=axes, label="$R^2$")
plt.show()

# %%
# The best point of each map:
for name, grid in maps.items():
    best = grid.r2_identity.isel(grid.r2_identity.argmax(...))
    kp, ki = float(best["controller.kp"]), float(best["controller.ki"])
    print(f"{name}: R2 = {float(best):.3f} at kp = {kp:.0f}, ki = {ki:.0f}")
