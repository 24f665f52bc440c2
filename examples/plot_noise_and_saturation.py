"""
Sensor noise and saturation
===========================

The paper finds noise above :math:`10^{-4}` N harmful but does not say in which
measure. Here the rms of the sensor noise runs from 1 µN to 1 N; the vertical lines
are the three ways to read the printed number at 5 kHz.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

kps, rms_n = [5.0, 10.0, 20.0], np.geomspace(1e-6, 1.0, 40)
axes = {"controller.kp": kps, "sensor.noise_rms_n": rms_n}
metrics = {"r2_identity": "$R^2$", "saturation_index": "saturated share"}
grid = fl.sweep(fl.feasible(), axes, duration_s=10.0, seeds=2, metrics=list(metrics))
grid = grid.mean("seed")

# %%
at_5_khz = np.sqrt(2500.0)
readings = {"rms": 1e-4, "density": 1e-4 * at_5_khz, "variance": np.sqrt(1e-4)}
figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.0))
for axis, (metric, label) in zip(axes, metrics.items(), strict=True):
    for kp, style in zip(kps, ("-", "--", ":"), strict=True):
        values = grid[metric].sel({"controller.kp": kp})
        axis.plot(rms_n, values, style, label=f"$K_p$ = {kp:g}")
    for x in readings.values():
        axis.axvline(x, color="0.6", linewidth=0.8)
    axis.set(xscale="log", xlabel="rms of the sensor noise (N)", ylabel=label)
for name, x in readings.items():
    axes[0].text(0.93 * x, 0.03, name, rotation=90, ha="right", fontsize=7.5)
axes[0].set_ylim(0, 1.02)
axes[0].legend(loc="center left")
plt.show()
