"""The bench against a second simulator, written from the equations alone: an adaptive ODE solver and plain Python.

Everything is continuous here: motion and load by their formulas, plate, friction limit, contact with skin, suspension
and pole by DOP853 from command to command. What the two have in common is the semantics (DESIGN) and the table of
roughness.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import frictionloop as fl
from frictionloop.physics.roughness import CELLS, roughness_table

RTOL, ATOL = 1e-9, np.array([1e-13, 1e-10, 1e-14, 1e-10, 1e-10, 1e-10])


def stroke(m, t):
    """Position (m), speed (m/s) and direction of a cycle that begins at rest at the left end."""
    v, plateau, turn = 1e-3 * m.speed_mm_s, m.plateau_s, m.reversal_s
    tau = (t / m.cycle_s + m.start) % 1.0 * m.cycle_s
    leftwards, tau = tau >= m.cycle_s / 2, tau % (m.cycle_s / 2)
    full = 2 * v * turn / 2 * (0.75 - 0.125) + v * plateau
    if min(tau, m.cycle_s / 2 - tau) < turn / 2:
        z = 2 * min(tau, m.cycle_s / 2 - tau) / turn
        way, speed = v * turn / 2 * (0.75 * z**2 - 0.125 * z**4), v * (1.5 * z - 0.5 * z**3)
        way = way if tau < m.cycle_s / 4 else full - way
    else:
        way, speed = v * turn / 2 * 0.625 + v * (tau - turn / 2), v
    sign = -1.0 if leftwards else 1.0
    return sign * (way - full / 2), sign * speed, sign


def contact_share(m, t):
    """c(t): 1 in contact, 0 lifted, and 3 y^2 - 2 y^3 in between."""
    if m.contact_s == 0:
        return 1.0
    tau = t % (m.contact_s + m.lifted_s)
    y = min(max(min(tau, m.contact_s - tau) / m.landing_s, 0.0), 1.0)
    return y * y * (3 - 2 * y)


class Bench:
    """The plant: continuous state, advanced under a held amplitude command."""

    def __init__(self, system, seed):
        self.s, f = system, system.finger
        self.rough = roughness_table(system.friction.roughness_rms, seed)
        self.skin = (f.stiffness_n_m, f.damping_n_s_m, f.mass_kg, 1e-6 * f.slip_length_um) if f.kind == "skin" else None
        self.law = "bristle" if f.kind == "skin" else "rigid"
        self.a = 0.0
        _, speed, sign = stroke(system.motion, 0.0)
        limit = self.limit(0.0, 0.0)
        force = (math.copysign(1.0, speed) if self.law == "rigid" or abs(speed) >= 1e-3 else 0.0) * limit
        pushed = force + sign * system.disturbance.offset_n
        k = self.skin[0] if self.skin else math.inf
        self.y = np.array([force / k, 0.0, force, pushed, 0.0, pushed])
        self.force = force

    def limit(self, t, a):
        fr, m = self.s.friction, self.s.motion
        x, v, _ = stroke(m, t)
        load = m.load_n * contact_share(m, t)
        w = -math.expm1(-t / fr.occlusion_s)  # in contact since t = 0
        cells = x * CELLS / (1e-3 * fr.roughness_longest_mm)
        place = 1 + np.interp(cells % CELLS, np.arange(CELLS + 1), np.append(self.rough, self.rough[0]))
        slow, v0 = 1e-3 * fr.slow_mm_s, 1e-3 * fr.reference_speed_mm_s
        speed = ((v * v + slow * slow) / (v0 * v0 + slow * slow)) ** (fr.speed_slope / 2)
        factor = (load / fr.reference_load_n) ** fr.load_exponent * speed * (1 + (fr.occlusion_ratio - 1) * w) * place
        return fr.nominal_n * factor * math.exp(-fr.susceptibility_per_um2 * (1 - fr.moist_loss * w) * a * a)

    def hold(self, t0, t1, command):
        """Advance to t1; ``force`` is then that at t1."""
        top, wc = self.s.plate.max_amplitude_um, 2 * math.pi * self.s.plate.cutoff_hz
        goal, a0 = min(max(command, 0.0), top), self.a

        def bound(t):
            return self.limit(t, goal + (a0 - goal) * math.exp(-wc * (t - t0)))

        rates = self.equations(bound)
        # A contact that has hardly a limit is stiff.
        stiff = self.law != "rigid" and min(bound(t0), bound(t1)) < 0.02
        found = solve_ivp(rates, (t0, t1), self.y, "LSODA" if stiff else "DOP853", rtol=RTOL, atol=ATOL)
        assert found.success
        self.y = found.y[:, -1]
        self.a = goal + (a0 - goal) * math.exp(-wc * (t1 - t0))
        self.force = self.contact(t1, self.y, bound)[0]

    def contact(self, t, y, bound):
        """Friction force, and how fast it rises."""
        speed = stroke(self.s.motion, t)[1]
        if self.law == "rigid":
            return math.copysign(bound(t), speed), 0.0
        force, v = y[2], speed - y[1]
        return force, (v * bound(t) - abs(v) * force) / self.skin[3]

    def equations(self, bound):
        sensor, d = self.s.sensor, self.s.disturbance.offset_n
        w0, pole = 2 * math.pi * sensor.resonance_hz, 2 * math.pi * sensor.cutoff_hz
        k, c, m, _ = self.skin or (0.0, 0.0, math.inf, 0.0)

        def rates(t, y):
            x, rate, _, x1, x2, x3 = y
            force, bristle = self.contact(t, y, bound)
            pushed = force + stroke(self.s.motion, t)[2] * d
            lag = [rate, (force - c * rate - k * x) / m, bristle] if self.skin else [0.0, 0.0, 0.0]
            return [*lag, w0 * x2, w0 * (pushed - x1) - w0 / sensor.q * x2, pole * (x1 - x3)]

        return rates


def solve(system, periods, seed):
    """Return traces f_a, f_m, a and u."""
    c, plant = system.controller, Bench(system, seed)
    dt, r, model = 1 / c.rate_hz, system.setpoint, c.model
    late = int(c.delay_s / dt + 1e-9)
    rest = c.delay_s - late * dt
    commands, integral, out = deque([0.0] * (late + 2), maxlen=late + 2), 0.0, []
    pole = math.exp(-2 * math.pi * system.touch.position.tracking_hz * dt)
    tracked, speed = stroke(system.motion, 0.0)[:2]
    cells = system.touch.load
    mean = system.motion.load_n * contact_share(system.motion, 0.0)
    # The tip stays in the middle of a play that the finger drags.
    play, turn, heads = 1e-3 * cells.developed_mm, 1e-3 * cells.turn_mm, 1
    slides = mean > 0 and abs(speed) >= 0.5e-3 * system.motion.speed_mm_s
    at, tip = 0.0, -play if slides else 0.0
    farthest, usual = at, abs(speed)
    for k in range(periods):
        t = k * dt
        x, _, sign = stroke(system.motion, t)
        pressed = system.motion.load_n * contact_share(system.motion, t)
        touches, presses = pressed >= cells.touch_n, pressed >= max(cells.touch_n, cells.touch_share * mean)
        if touches:
            mean += (1 - math.exp(-dt / cells.mean_s)) * (pressed - mean)
            error = x - (tracked + speed * dt)
            tracked, speed = tracked + speed * dt + (1 - pole**2) * error, speed + (1 - pole) ** 2 / dt * error
            at += speed * dt
            tip = min(max(tip, at - play), at + play) if presses else tip + speed * dt
            farthest = heads * max(heads * farthest, heads * at)
            if heads * (farthest - at) > turn:
                heads, farthest = -heads, at
            usual += (1 - math.exp(-dt / cells.mean_s)) * (abs(speed) - usual)
        else:
            tracked, speed, tip, farthest = x, 0.0, at, at
        stretched = heads * (at - tip) >= play - 1e-12
        fast = abs(speed) >= max(1e-3 * cells.least_speed_mm_s, cells.speed_share * usual)
        valid = presses and fast and stretched
        f_m = plant.y[5] * heads
        wanted = r.levels_n[max(i for i, start in enumerate(r.times_s) if start <= t + 1e-9)]
        e = wanted - f_m if valid else 0.0
        v = c.kp * e + integral
        u = min(max(v, model.floor_n), model.nominal_n)
        if not (v > model.nominal_n and e > 0) and not (v < model.floor_n and e < 0):
            integral += c.ki * dt * e
        out.append((sign * plant.force + system.disturbance.offset_n, f_m, plant.a, u))
        commands.append(math.sqrt(math.log(model.nominal_n / u) / model.susceptibility_per_um2))
        cuts = [t, *([t + rest] if rest > 1e-9 * dt else []), t + dt]
        for start, stop in pairwise(cuts):
            plant.hold(start, stop, commands[0] if start < t + rest - 1e-12 else commands[1])
    return dict(zip(("f_a", "f_m", "a", "u"), np.array(out).T, strict=True))


BASE = fl.bench().evolve(
    {
        **fl.RETUNED, "setpoint": fl.Steps(times_s=(0.0, 0.02, 0.03), levels_n=(0.6, 0.35, 0.8)),
        "motion.start": 0.25, "motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0,
        "sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32, "touch.position.noise_um": 0.0,
        "touch.load.noise_n": 0.0, "friction.occlusion_s": 0.5, "friction.speed_slope": -0.1,
        "disturbance": fl.Constant(offset_n=0.05), "sensor.q": 1.0, "controller.ki": 400.0, "controller.kp": 0.3,
    }
)  # fmt: skip
# Over a turn a disturbance turns with the finger, here at once and in the simulator at the next sample: none.
REVERSAL = {"motion.start": 0.4921, "disturbance": fl.Constant(offset_n=0.0)}
CASES = {
    "11.5 um, 200 us": ({}, 200),
    "11.5 um, no delay": ({"controller.delay_s": 0.0}, 300),
    "11.5 um, 330 us": ({"controller.delay_s": 330e-6}, 300),
    "11.5 um, the printed gains": ({"controller.kp": 10.0, "controller.ki": 2.0}, 300),
    "11.5 um, a reversal": ({"controller.delay_s": 330e-6, **REVERSAL}, 500),
    "11.5 um, from rest": ({"motion.start": 0.0}, 500),
    "11.5 um, a landing": ({"motion.contact_s": 1.0, "motion.landing_s": 0.03}, 300),
    "30 um, 200 us": ({"finger.slip_length_um": 30.0}, 300),
    "rigid, 330 us": ({"finger": fl.RigidFinger(), "controller.delay_s": 330e-6}, 300),
}  # fmt: skip


QUICK = {"11.5 um, 200 us", "11.5 um, a landing", "rigid, 330 us"}


@pytest.mark.parametrize("name", [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in CASES])
def test_the_bench_is_the_equations(name):
    overrides, periods = CASES[name]
    system = BASE.evolve(overrides)
    kp = system.controller.kp
    run, exact = fl.simulate(system, periods / 5000.0, seed=3), solve(system, periods, 3)
    assert np.ptp(exact["f_a"]) > 0.1  # something happens
    # A millinewton is asked of the force, half of it of f_m, which kp multiplies in u. The choice of the anti-windup
    # may fall a period apart; near u = f0 amplitude is the root of what is left.
    for key, most, rms in (
        ("f_a", 1e-3, 1.5e-4),
        ("f_m", 5e-4, 1e-4),
        ("u", max(2e-3, 5e-4 * kp), max(3e-4, 1e-4 * kp)),
        ("a", 0.01, 2e-3),
    ):
        error = np.abs(run[key].values - exact[key])
        assert error.max() < most, key
        assert math.sqrt(np.mean(error**2)) < rms, key
