"""
Two kinds of R², and how good they can get
==========================================

With the paper's printed signals no controller can follow: the set-point leaves the
band of forces that the plate can make. Half of :math:`R^2` is lost before the
controller does anything. The regression that the paper uses for its experiment is
kinder than the distance to :math:`f_a = f_r`, because it forgives a wrong gain and
offset.
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

system = fl.paper()
run = fl.simulate(system, duration_s=10.0)
floor_n, nominal_n = fl.reachable(system)
line = fl.regression(run)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2), width_ratios=(3, 2))
part = run.sel(time=slice(0, 1.5))
left.fill_between(
    part.time, floor_n + part.d, nominal_n + part.d, color="0.9", label="reachable"
)
left.plot(part.time, part.f_r, "0.35", linestyle="--", linewidth=1.0, label="$f_r$")
left.plot(part.time, part.f_a, label="$f_a$")
left.set(xlabel="time (s)", ylabel="force (N)")
left.legend(loc="upper center", ncols=3, bbox_to_anchor=(0.5, 1.15))
ends = np.array([0.0, 1.2])
right.plot(run.f_r[::50], run.f_a[::50], ".", markersize=2, alpha=0.5)
right.plot(ends, ends, "k", linewidth=1.0, label="$f_a = f_r$")
right.plot(
    ends, line.slope * ends + line.intercept_n, "--", color="C2", label="regression"
)
right.set(xlabel="$f_r$ (N)", ylabel="$f_a$ (N)")
right.legend()
plt.show()

# %%
print(f"R2 against f_a = f_r:        {fl.r2_identity(run):.3f}")
print(f"  the best there could be:   {fl.r2_bound(run):.3f}")
print(f"R2 of the regression:        {line.r2:.3f}")
print(f"  its slope and intercept:   {line.slope:.2f}, {line.intercept_n:.2f} N")

# %%
# Scored only where the set-point is in reach, the same run looks like this:
in_reach = (run.f_r >= floor_n + run.d) & (run.f_r <= nominal_n + run.d)
r2 = fl.r2_identity(run, in_reach)
print(f"{float(in_reach.mean()):.0%} of the time in reach: R2 = {r2:.3f} there")
