"""The tracker against the same law written anew: natural logarithms, vectors and matrices, from its equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import frictionloop as fl
from frictionloop.control.tracker import tracker_step
from frictionloop.control.tracker_gains import tracker_gains, tracker_start
from frictionloop.control.tracker_state import TrackerState
from frictionloop.parameters.tracking import TrackerController
from frictionloop.sensing.measurement import Measurement

LN2 = np.log(2.0)
DT = 1.0 / 5000
RTOL = 1e-9
SLOW = (0.07, 0.125, 0.25, 0.5, 0.75, 1.0, 1.25)
CASES = {
    "bench": {},
    "slow delay": {"delay_s": 1.1e-4, "load_exponent": 0.7},
    "other springs": {"resonance_share": 1.05, "broadened_q": 8.0, "skin_stiffness_n_m": 300.0},
    "eager": {"compliance_learning": 0.3, "susceptibility_learning": 1e-3, "largest_jump_n": 0.1},
}


def controller(**changes):
    return TrackerController(**{"model": fl.bench().controller.model, "rate_hz": 5000, "delay_s": 2e-4} | changes)


def believed_sensor(c):
    """x' = A x + b f for springs (force, rate/w) and pole, over a period with f linear: phi functions of A dt.

    The springs are taken for softer and for more damped than the model says.
    """
    w, p = 2 * np.pi * c.resonance_share * c.model.resonance_hz, 2 * np.pi * c.model.sensor_hz
    A = np.array([[0, w, 0], [-w, -w / c.broadened_q, 0], [p, 0, -p]]) * DT
    b = np.array([0, w, 0]) * DT
    whole, inverse = expm(A), np.linalg.inv(A)
    phi1 = inverse @ (whole - np.eye(3))
    phi2 = inverse @ (phi1 - np.eye(3))
    return whole, (phi1 - phi2) @ b, phi2 @ b


class Tracker:
    """Extended Kalman filter with a gain by schedule, and a recursive prediction error method for two parameters."""

    def __init__(self, c):
        self.c, self.model, self.columns = c, c.model, np.array(c.schedule).T
        self.A, self.b0, self.b1 = believed_sensor(c)
        self.calmed = self.shaken = self.leaps = self.drops = self.leaned = 0
        self.let_go = self.hastened = self.quick = 0
        given = tracker_gains(c).own
        self.stuck = np.array([0.0, given.stuck_friction, given.stuck_spring, given.stuck_rate, given.stuck_reading])
        self.put(tracker_start(c))

    def put(self, s):
        """Be where the compiled law is; tau = ln 2 fall, so sensitivities by tau are 1/ln 2 of those by fall."""
        self.x = np.array([LN2 * s.limit, s.friction, s.spring, s.rate, s.reading])
        self.trusted, self.a, self.command, self.load = LN2 * s.trusted, s.amplitude, s.command, LN2 * s.load
        self.theta, self.power = np.array([s.compliance, LN2 * s.fall]), np.array([s.power_c, s.power_t / LN2**2])
        self.psi = np.array(s[19:29]).reshape(2, 5) / [[1.0], [LN2]]
        self.way_before, self.f_before = s.forward, s.friction_before
        self.rate, self.falls, self.leapt, self.slope = s.rising, s.falling, s.leapt, s.quick

    def state(self):
        """Return the state in the terms of the compiled law."""
        ln_limit, *rest = self.x
        return TrackerState(
            self.a, self.command, ln_limit / LN2, self.trusted / LN2, *rest, self.way_before, self.load / LN2,
            self.rate, self.falls, self.f_before, self.theta[0], self.theta[1] / LN2,
            self.power[0], self.power[1] * LN2**2, self.leapt, self.slope,
            *self.psi[0], *(LN2 * self.psi[1]),
        )  # fmt: skip

    def share(self, limit, v):
        return 1.0 / (1.0 + self.theta[0] * 1e-6 * max(limit, 0.05) / (v * DT))

    def scheduled(self, share, v):
        """Return the row: above 70.3125 mm/s of those at the end, else beyond 3/4 by the speed over 20 mm/s, too."""
        if v > 0.0703125:
            self.quick += 1
            downwards = [-0.75, -0.5, -0.25, -0.125]
            return np.array([np.interp(-share, downwards, column[6:]) for column in self.columns])
        place = 0.75 + (share - 0.75) * (max(v / 0.02, 1.0) if share > 0.75 else 1.0)
        self.hastened += place > share + 1e-9
        return np.array([np.interp(place, SLOW, column[:7]) for column in self.columns])

    def stuckness(self, limit, steepest, valid):
        if valid == 0 or self.x[1] < 0:
            return 1.0
        gap = 1 - self.x[1] / max(limit, 0.02)
        return 0.0 if self.rate < steepest / 4 else float(np.clip((gap - 0.1) / 0.1, 0, 1))

    def learn(self, error, v):
        """theta += gamma psi e / R, R the mean of psi^2 (Ljung, ch. 11), tau in 1/um^2 and c in um/N.

        What makes c larger counts by c over 20.8 um/N, above 20 mm/s by the square of the speed more, down to a fifth.
        """
        seen, eps = self.psi[:, 4], np.array([1e-10, 5e-9 / LN2**2])
        self.power += 4e-4 * (seen**2 - self.power)
        gamma = np.array([self.c.compliance_learning, self.c.susceptibility_learning])
        top = [self.c.largest_compliance_um_per_n, 3.0 * LN2]
        step = np.clip(gamma * seen * error / (self.power + eps), [-2.0, -2e-4 * LN2], [2.0, 2e-4 * LN2])
        if step[0] > 0:
            counted = np.clip(self.theta[0] / 20.8333333333 * max(v / 0.02, 1.0) ** 2, 0.2, 1.0)
            step[0] *= counted
            self.leaned += counted < 1.0
        self.theta = np.clip(self.theta + step, [0, 0.2 * LN2], top)

    def calm(self, steepest, v, valid):
        """Friction that falls twice as steeply as the skin can load: take it for quicker and better lubricated.

        A tick of that takes 0.2 % off the compliance and adds 0.1 % to tau, within the bounds of what is learnt. Where
        falls, smoothed a little, exceed that slope by a quarter of it on average, and by 5 N/s at 10 mm/s, the slower
        the more, only the compliance pays, and not below 20 um/N.
        """
        if not valid:
            return
        steep = self.rate < -2 * steepest
        if steep or (self.theta[0] > 20.0 and self.falls > max(steepest / 4, 0.05 / v)):
            self.theta[0] *= 1 - 2e-3
            self.shaken += not steep
        if steep:
            self.theta[1] = min(self.theta[1] * (1 + 1e-3), 3.0 * LN2)
            self.calmed += 1

    def tick(self, y, speed, load, valid, setpoint):
        c, m, jump = self.c, self.model, self.c.largest_jump_n
        way = 1.0 if speed >= 0 else -1.0
        turned = way * self.way_before < 0
        if turned:
            self.x[1:] *= -1
            self.f_before *= -1
        v = max(abs(speed), 0.002)
        steepest = c.skin_stiffness_n_m * v
        self.load += -np.expm1(-2 * np.pi * c.load_hz * DT) * (np.log(max(2 * load, 0.04)) - self.load)
        push, tau = c.load_exponent * self.load, self.theta[1]

        error, psi = y - self.x[4], self.psi
        limit = np.exp(self.x[0] + push - tau * self.a**2)
        share = self.share(self.x[1], v)
        row = self.scheduled(share, v)
        K, lead, trust = row[:5], row[5], row[6]
        w = self.w = self.stuckness(limit, steepest, valid)
        leaping = valid == 1 and abs(setpoint - self.x[1]) > 0.15
        steady = w == 0 and self.x[1] > 0.15 and abs(error) < 0.03 and abs(self.rate) < steepest / 2
        if steady and not leaping and self.leapt == 0:
            self.learn(error, v)
        drop = (self.f_before - self.x[1]) / DT
        sudden = leaping and self.x[1] > setpoint and drop > 1.2 * steepest
        self.leapt = 1.0 if sudden else max(self.leapt - 1.0 / 16.0, 0.0)
        self.calm(steepest, v, valid)
        tau = self.theta[1]
        f_before = self.x[1]
        step = np.clip(np.clip(K[0] * error, -jump, jump) / np.clip(self.x[1], 0.1, 2.0), -0.4, 0.4)
        up = (1 - self.leapt) * (1 - w) * step
        self.x[0] = np.clip(self.x[0] + up, -3.3 * LN2, 5.0 * LN2)
        limit *= 1 + up
        self.x[1] += w * self.stuck[1] * error + (1 - w) * np.clip(K[1] * error, -2 * jump, 2 * jump)
        self.x[1] = np.clip(self.x[1], -5.0, 5.0)
        self.x[2:] += ((1 - w) * K[2:] + w * self.stuck[2:]) * error
        slope = (self.x[1] - self.f_before) / DT
        self.rate += 0.1 * (slope - self.rate)
        self.slope = (self.slope + slope) / 2
        self.falls += 0.02 * (-min(self.slope + steepest, 0.0) - self.falls)
        f = self.x[1]

        rest, pole = min(c.delay_s / DT, 1.0), 2 * np.pi * m.plate_hz * DT
        a_then = self.command + (self.a - self.command) * np.exp(-pole * rest)
        self.leaps, self.drops = self.leaps + leaping, self.drops + (self.leapt == 1.0)
        slope = np.clip(0.9 * m.susceptibility_per_um2, 0.2 * LN2, 3.0 * LN2) if leaping else tau
        # From here on ln L = level - slope a^2, through the limit that is believed now.
        level = self.x[0] - (tau - slope) * self.a**2
        limit_then = np.exp(level + push - slope * a_then**2)
        mean = (limit + limit_then) / 2
        share = self.share(mean, v)
        mean = limit_then if share > 0.97 else mean
        f_then = f + rest * min(share * (mean - f), 1.2 * steepest * DT)
        f_next = f + min(share * (mean - f), 1.2 * steepest * DT)

        rises = self.command == 0.0 and setpoint - f_then > 0.03
        self.let_go += rises
        wanted = max(f_then + (setpoint - f_then) / lead, 0.02)
        self.trusted += trust * (self.x[0] - self.trusted)
        over = self.trusted - (tau - slope) * self.a**2 + push - np.log(wanted)
        square = 0.0 if rises else float(np.clip(over / slope, 0, m.max_amplitude_um**2))
        overshoot = (np.sqrt(square) - a_then * np.exp(-pole)) / (1 - np.exp(-pole))
        command = float(np.clip(overshoot, 0, m.max_amplitude_um))
        u = m.nominal_n * np.exp(-m.susceptibility_per_um2 * square)

        lost = turned or abs(psi[0, 4]) > 0.02 or LN2 * abs(psi[1, 4]) > 4.0
        # Sensitivities of the state after the correction, then over the period.
        added = [
            np.clip(-(share**2) * 1e-6 * max(mean, 0.05) / (v * DT) * (mean - f), -1.0, 1.0),
            -share * mean * (self.a**2 + a_then**2) / 2,
        ]
        gain = K * [(1 - w) / np.clip(f_before, 0.1, 2.0), 1 - w, 1, 1, 1]
        for s, more in zip(psi, added, strict=True):
            s[:] = (0.0 if lost else 1.0) * (s - gain * s[4])
            after = s[1] + share * (mean * s[0] - s[1]) + more
            s[2:] = self.A @ s[2:] + self.b0 * s[1] + self.b1 * after
            s[1] = after
        self.x[2:] = self.A @ self.x[2:] + self.b0 * f + self.b1 * f_next
        self.x[1], self.f_before, self.way_before = f_next, f, way
        a_next = command + (a_then - command) * np.exp(-pole * (1 - rest))
        moved = np.clip(level + (tau - slope) * a_next**2, -3.3 * LN2, 5.0 * LN2) - self.x[0]
        self.x[0], self.trusted = self.x[0] + moved, self.trusted + moved
        self.a, self.command = a_next, command
        return float(np.clip(u, m.floor_n, m.nominal_n))


def readings(seed, ticks=4000):
    """Yield a finger's slides: friction about the set-point, reversals, stops, lifts, other loads and speeds."""
    rng = np.random.default_rng(seed)
    speed, load, valid, level = 0.02, 0.5, 1.0, 0.6
    force, slow = 0.6, 0.0
    for k in range(ticks):
        if rng.random() < 2e-3:
            speed = float(rng.choice([-1, 1]) * rng.choice([0.0, 0.001, 0.01, 0.02, 0.04, 0.08, 0.15]))
        if rng.random() < 1e-3:
            load, valid = float(rng.choice([0.0, 0.05, 0.3, 0.5, 1.2])), float(rng.random() < 0.8)
        slow += -2e-3 * slow + 2e-3 * rng.normal()
        aim = 0.0 if valid == 0 else level + slow
        force += 0.1 * (aim - force)
        yield force + 1e-3 * rng.normal(), speed, load, valid, 0.65 + 0.2 * np.sin(0.004 * k)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 3))])
def test_the_compiled_step_is_the_law_written_anew(case, seed):
    """Command and all 29 states, tick by tick from the same state.

    From the same start alone they part: readings that do not answer to commands leave an open loop that amplifies
    rounding, tenfold every 100 ticks in places.
    """
    c = controller(**CASES[case])
    own, gains = Tracker(c), tracker_gains(c)
    state, inside, stuck, forces, states = tracker_start(c)._replace(compliance=60.0), 0, 0, [], []
    for k, (y, speed, load, valid, setpoint) in enumerate(readings(seed, 8000)):
        if k % 500 == 250:
            state = state._replace(compliance=4.0)  # nearly a slider: gains go by speed, and steps up lean
        own.put(state)
        wanted = own.tick(y, speed, load, valid, setpoint)
        state, (u, saturated) = tracker_step(state, Measurement(y, 0.0, speed, load, valid), setpoint, gains, DT)
        forces.append((u, wanted))
        states.append((state, own.state()))
        inside, stuck = inside + (saturated == 0.0), stuck + (own.w > 0.0)
    (u, wanted), (state, own_state) = np.array(forces).T, np.array(states).swapaxes(0, 1)
    np.testing.assert_allclose(u, wanted, rtol=RTOL)
    np.testing.assert_allclose(state, own_state, rtol=RTOL, atol=1e-12)
    assert inside > 1000 and stuck > 50 and own.calmed > 50 and own.shaken > 50
    assert own.leaps > 50 and own.drops > 5 and own.leaned > 50 and own.let_go > 50  # all ways were gone
    assert own.hastened > 50 and own.quick > 50


def test_they_stay_together_while_the_finger_slides():
    """Two independent runs of 1,000 ticks around the set-point: where friction answers, nothing is amplified."""
    c, rng = controller(compliance_um_per_n=0.0), np.random.default_rng(4)
    own, gains = Tracker(c), tracker_gains(c)
    state, limit = tracker_start(c), 0.9
    x, f = np.zeros(3), 0.0
    for _ in range(1000):
        y = x[2] + 1e-4 * rng.normal()
        state, (u, _) = tracker_step(state, Measurement(y, 0.0, 0.03, 0.5, 1.0), 0.6, gains, DT)
        assert u == pytest.approx(own.tick(y, 0.03, 0.5, 1.0, 0.6), rel=RTOL)
        limit *= np.exp(2e-3 * rng.normal())
        f_next = limit * np.exp(-0.45 * state.amplitude**2)
        x, f = own.A @ x + own.b0 * f + own.b1 * f_next, f_next
    np.testing.assert_allclose(state, own.state(), rtol=1e-7, atol=1e-10)
    assert abs(own.x[1] - 0.6) < 0.05
