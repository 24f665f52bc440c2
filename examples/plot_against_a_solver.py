"""
An independent solver agrees
============================

The loop of the model page, written again from its equations: SciPy integrates plate
and sensor between samples with a tight tolerance, the controller is eight lines of
Python. Both start from the same state; noise is off.
"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import frictionloop as fl

system = fl.paper().evolve({"sensor.noise_rms_n": 0.0})
run = fl.simulate(system, duration_s=0.2)

# %%
f0, tau, a_max = 0.8, 0.38, 2.5
plate, sensor, dt = 2 * np.pi * 100, 2 * np.pi * 1000, 1 / 5000
low = f0 * np.exp(-tau * a_max**2)
kp, ki = 10.0, 2.0


def f_r(t):
    return 0.6 + 0.6 * np.sin(2 * np.pi * 10 / np.log(100) * (100 ** (t / 10) - 1))


def f_a(a, t):
    return f0 * np.exp(-tau * a**2) + 0.4 + 0.4 * np.sin(2 * np.pi * t)


def slope(t, state, command):
    a, f_m = state
    return [plate * (command - a), sensor * (f_a(a, t) - f_m)]


state, integral, forces, measured = np.array([0.0, f_a(0.0, 0.0)]), 0.0, [], []
for k in range(1000):
    t = k * dt
    forces.append(f_a(state[0], t))
    measured.append(state[1])
    e = f_r(t) - state[1]
    v = kp * e + integral
    u = min(max(v, low), f0)
    if not ((v > f0 and e > 0) or (v < low and e < 0)):
        integral += ki * dt * e
    command = np.sqrt(np.log(f0 / u) / tau)
    state = solve_ivp(
        slope, (t, t + dt), state, "DOP853", args=(command,), rtol=1e-12, atol=1e-14
    ).y[:, -1]

# %%
figure, axis = plt.subplots(figsize=(6.6, 2.8))
for name, reference in (("f_a", forces), ("f_m", measured)):
    difference_n = np.abs(run[name].values - reference)
    axis.semilogy(run.time, difference_n + 1e-18, linewidth=0.8, label=f"${name}$")
    print(f"{name}: largest difference {np.max(difference_n):.1e} N")
axis.set(xlabel="time (s)", ylabel="difference (N)")
axis.legend()
plt.show()
