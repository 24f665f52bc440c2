"""
A recording as disturbance
==========================

What would the loop do for a finger that somebody measured? Any column of a file can
be the disturbance. Here the file is made up, a friction force that drifts and
flickers, sampled at 1 kHz in millivolts.
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.signal import welch

import frictionloop as fl

random = np.random.default_rng(1)
t = np.arange(10_001) / 1000
flicker = np.cumsum(random.normal(size=t.size))
force_n = (
    0.8
    + 0.05 * np.sin(2 * np.pi * 0.3 * t)
    + 0.03 * (flicker - flicker.mean()) / flicker.std()
)
file = Path(tempfile.mkdtemp()) / "slide.csv"
np.savetxt(
    file,
    np.column_stack([t, 500 * force_n]),
    delimiter=",",
    header="time_s,force_mv",
    comments="",
)

# %%
# The rate comes from the column ``time_s``; 500 mV are 1 N; the part that varies is
# kept, around 0.15 N.
recorded = fl.Recording(
    path=str(file),
    column="force_mv",
    scale=1 / 500,
    unit="mV",
    remove_mean=True,
    offset_n=0.15,
)
system = fl.paper().evolve(
    {"disturbance": recorded, "setpoint": fl.Constant(offset_n=0.55)}
)
run = fl.simulate(system, duration_s=10.0)
settled = run.sel(time=slice(0.5, None))

# %%
# Open loop, with the plate at a constant amplitude, the finger would feel all of
# ``d``.
figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0))
left.plot(settled.time, settled.d - settled.d.mean(), label="open loop")
left.plot(settled.time, settled.f_a - settled.f_r, label="closed loop")
left.set(xlabel="time (s)", ylabel="error (N)")
left.legend(loc="lower left")
for trace, label in ((settled.d, "open loop"), (settled.f_a, "closed loop")):
    f, density = welch(trace, fs=5000, nperseg=2**13)
    kept = (f > 0) & (f < 400)  # the recording ends at 500 Hz, half of its rate
    right.loglog(f[kept], np.sqrt(density[kept]), label=label)
right.set(xlabel="frequency (Hz)", ylabel="N/√Hz")
plt.show()

open_mn, closed_mn = 1e3 * float(settled.d.std()), 1e3 * fl.output_noise(settled)
print(f"variation of the force: {open_mn:.1f} mN open, {closed_mn:.1f} mN closed")
