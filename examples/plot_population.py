"""
A population on the bench
=========================

Friction differs from finger to finger by more than the plate can take away. Two
hundred fingers slide on the bench with the re-tuned gains, each asked for
0.6 ± 0.1 N. Which of them can get it at all, and how well do they?
"""

import matplotlib.pyplot as plt
import numpy as np

import frictionloop as fl

bench = fl.bench().evolve(fl.RETUNED)
people = fl.fingers(200, seed=1)
names = ["rms_error", "perceptual_index"]
score = fl.sweep(bench, people, duration_s=5.0, metrics=names).squeeze("seed")
able = fl.capable(people, low_n=0.5, high_n=0.7, contact_s=5.0)
count = able[["capable", "reaches_low", "reaches_high"]].sum()
print(f"{count.capable.item()} of {len(people)} can be given 0.5 to 0.7 N for 5 s")
print(f"{len(people) - count.reaches_low.item()} cannot get down to 0.5 N")
print(f"{len(people) - count.reaches_high.item()} cannot get up to 0.7 N")

# %%
# Each line is a finger, from the lowest force that 2.5 µm leave to the highest it has
# without vibration; the band is what is asked for. The error of those that cover the
# band comes from the controller, that of the others mostly from the plate.
order = np.argsort(able.highest_n.values)
low, high, can = (
    able[name].values[order] for name in ("lowest_n", "highest_n", "capable")
)
error_mn = 1e3 * score.rms_error.values[order]
number = np.arange(order.size)

figure, (top, bottom) = plt.subplots(2, sharex=True, figsize=(6.6, 4.8))
top.axhspan(0.5, 0.7, color="0.9", label="asked for")
for group, colour, name in ((can, "C0", "can be given it"), (~can, "C1", "cannot")):
    top.vlines(number[group], low[group], high[group], color=colour, label=name)
    bottom.semilogy(number[group], error_mn[group], ".", color=colour)
top.set(ylabel="forces in reach (N)", ylim=(0, None))
bottom.set(xlabel="finger, by its friction", ylabel="rms error (mN)")
top.legend(loc="upper left", ncols=2)
plt.show()

# %%
# What is left on the capable ones? The loop removes slow changes of friction. What
# remains comes from the skin sliding over the glass, too fast for this loop, and it
# is what the index D weighs most: 1 would be the threshold of a resting finger.
roughness = np.array([finger["friction.roughness_rms"] for finger in people])
capable = able.capable.values
figure, axis = plt.subplots(figsize=(4.6, 3.0))
axis.loglog(100 * roughness[capable], score.perceptual_index.values[capable], ".")
axis.set(
    xlabel="roughness of the finger's friction (% rms)", ylabel="index D of the error"
)
axis.set_xticks([2, 5, 10], ["2", "5", "10"])
axis.set_yticks([10, 20, 50], ["10", "20", "50"])
axis.minorticks_off()
plt.show()
