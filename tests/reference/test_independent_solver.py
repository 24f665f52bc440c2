"""The simulator against a second one, written from the semantics alone: an adaptive ODE solver and plain Python.

Semantics (DESIGN): continuous plant, sampled controller, zero-order hold on the amplitude command, applied ``delay_s``
after its sample. At t = 0 amplitude and integral are 0 and the sensor has settled on the first force. Sampled signals
are linear between samples, steps land on t_k, the sensor noise n_k is held over period k.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest
from scipy.integrate import DOP853

import frictionloop as fl
from frictionloop.physics.signal_values import sampler
from frictionloop.quantities.counter_noise import normals

RTOL, ATOL = 1e-12, 1e-14
"""Of the solver, per step; that it has converged is tested below."""
CHECKED_N = 1e-8
"""The simulator promises 1e-6 N; a hundred times less is asked here, where the loop damps errors (kp < 15)."""


def signal(source, system, seed, stream, periods):
    """Return t -> force of a source, and its values at t_k, k = 0 ... periods."""
    rate = system.controller.rate_hz
    t = np.arange(periods + 1) / rate
    if source.kind == "constant":
        return (lambda _: source.offset_n), np.full(t.size, source.offset_n)
    if source.kind == "sine":

        def sine(t):
            return source.offset_n + source.amplitude_n * math.sin(2 * math.pi * source.frequency_hz * t)

        return sine, np.array([sine(x) for x in t])
    if source.kind == "log_sweep":
        growth = math.log(source.stop_hz / source.start_hz) / source.sweep_s

        def sweep(t):
            # The phase is the integral of the frequency start * e^(growth t).
            phase = 2 * math.pi * source.start_hz * math.expm1(growth * t) / growth
            return source.offset_n + source.amplitude_n * math.sin(phase)

        return sweep, np.array([sweep(x) for x in t])
    if source.kind == "steps":
        first = [math.ceil(start * rate - 1e-6) for start in source.times_s]
        values = [source.levels_n[max(i for i, k0 in enumerate(first) if k0 <= k)] for k in range(t.size)]
        return (lambda t: values[min(int(t * rate + 1e-6), periods)]), np.array(values)
    # Recordings and coloured noise are defined by their samples, which have tests of their own.
    values = sampler(source, rate, seed, stream)(0, periods)

    def linear(t):
        k = min(int(t * rate), periods - 1)
        return values[k] + (t * rate - k) * (values[k + 1] - values[k])

    return linear, values


class Inverse:
    """Force to amplitude by the controller's model: exactly, or linear in a^2 between evenly spaced forces."""

    def __init__(self, model):
        self.f0, self.tau, size = model.nominal_n, model.susceptibility_per_um2, model.table_size
        self.low = self.f0 * math.exp(-self.tau * model.max_amplitude_um**2)
        self.forces = np.linspace(self.low, self.f0, size) if size else None
        self.squares = np.log(self.f0 / self.forces) / self.tau if size else None

    def __call__(self, u):
        if self.forces is None:
            return math.sqrt(math.log(self.f0 / u) / self.tau)
        return math.sqrt(np.interp(u, self.forces, self.squares))


def solve(system, duration_s, seed=0):
    """Return the traces of a run, by ODE solver and plain Python."""
    c, plant = system.controller, (system.friction.nominal_n, system.friction.susceptibility_per_um2)
    plate, sensor = (2 * math.pi * block.cutoff_hz for block in (system.plate, system.sensor))
    rate, ceiling = c.rate_hz, system.plate.max_amplitude_um
    periods = round(duration_s * rate)
    _, setpoint = signal(system.setpoint, system, seed, 1, periods)
    d, d_at = signal(system.disturbance, system, seed, 2, periods)
    noise = system.sensor.noise_rms_n * normals(seed, 0, 0, periods)
    inverse = Inverse(c.model)
    held = system.disturbance.kind == "steps"

    def g(a):
        return plant[0] * math.exp(-plant[1] * a * a)

    def advance(state, t0, t1, command, n, d_held):
        def slope(t, y):
            d_now = d_held if held else d(t)
            return np.array([plate * (command - y[0]), sensor * (g(y[0]) + d_now + n - y[1])])

        solver = DOP853(slope, t0, state, t1, rtol=RTOL, atol=ATOL, first_step=(t1 - t0) / 2)
        while solver.status == "running":
            solver.step()
        assert solver.status == "finished"
        return solver.y

    rows, integral, command, waiting = [], 0.0, 0.0, deque()
    state = np.array([0.0, plant[0] + d_at[0]])
    for k in range(periods):
        t, end = k / rate, (k + 1) / rate
        a, f_m = (float(x) for x in state)
        e = setpoint[k] - f_m
        v = c.kp * e + integral
        u = min(max(v, inverse.low), inverse.f0)
        rows.append((setpoint[k], g(a) + d_at[k], f_m, u, a, d_at[k], v != u))
        if not ((v > u and e > 0) or (v < u and e < 0)):
            integral += c.ki / rate * e
        waiting.append((t + c.delay_s, min(max(inverse(u), 0.0), ceiling)))
        while t < end:
            while waiting and waiting[0][0] <= t + 1e-12:
                command = waiting.popleft()[1]
            stop = min([end, *(at for at, _ in list(waiting)[:1])])
            stop = end if end - stop < 1e-12 else stop
            state = advance(state, t, stop, command, noise[k], d_at[k])
            t = stop
    return dict(zip(("f_r", "f_a", "f_m", "u", "a", "d", "saturated"), np.array(rows).T, strict=True))


SHORT_S = 0.15
LIVELY = {"setpoint.sweep_s": SHORT_S, "disturbance.frequency_hz": 11.0}  # 1 to 100 Hz within the run
NOISY = {"sensor.noise_rms_n": 1e-3}
MISMATCH = {
    "controller.model.nominal_n": 0.9,
    "controller.model.susceptibility_per_um2": 0.5,
    "controller.model.max_amplitude_um": 2.2,
}
CASES = {
    "paper": {},
    "kp 1": {"controller.kp": 1.0},
    "kp 14": {"controller.kp": 14.0},
    "proportional only": {"controller.ki": 0.0, "controller.kp": 5.0},
    "integral only": {"controller.kp": 0.0, "controller.ki": 200.0},
    "large ki": {"controller.kp": 5.0, "controller.ki": 2000.0},
    "delay of one period": {"controller.delay_s": 200e-6},
    "delay of three periods": {"controller.delay_s": 600e-6, "controller.kp": 5.0},
    "delay of 37 us": {"controller.delay_s": 37e-6},
    "delay of 199 us": {"controller.delay_s": 199e-6},
    "delay of 330 us": {"controller.delay_s": 330e-6, "controller.kp": 5.0},
    "delay of 1.234 ms": {"controller.delay_s": 1.234e-3, "controller.kp": 2.0},
    "table of 2": {"controller.model.table_size": 2, "controller.kp": 3.0},
    "table of 32": {"controller.model.table_size": 32},
    "table of 1024 and a delay": {"controller.model.table_size": 1024, "controller.delay_s": 150e-6},
    "the model is not the plant": MISMATCH,
    "the drive is weaker than believed": {"plate.max_amplitude_um": 1.5},
    "noise": NOISY,
    "much noise and a delay": {"sensor.noise_rms_n": 0.1, "controller.delay_s": 250e-6, "controller.kp": 4.0},
    "sensor of 300 Hz": {"sensor.cutoff_hz": 300.0, "controller.kp": 4.0},
    "sensor of 20 kHz": {"sensor.cutoff_hz": 2e4, "controller.kp": 4.0},
    "plate of 20 Hz": {"plate.cutoff_hz": 20.0},
    "plate of 500 Hz": {"plate.cutoff_hz": 500.0, "controller.kp": 2.0},
    "the fastest plate for one piece a period": {"plate.cutoff_hz": 174.0, "controller.kp": 3.0},
    "a plate for two pieces a period": {"plate.cutoff_hz": 299.0, "controller.kp": 3.0},
    "the fastest plate of all": {"plate.cutoff_hz": 4890.0, "controller.kp": 1.0, "controller.delay_s": 50e-6},
    "a disturbance of 1 kHz": {"disturbance.frequency_hz": 1000.0},
    "rate of 1 kHz": {"controller.rate_hz": 1000.0, "controller.kp": 2.0},
    "rate of 200 Hz": {"controller.rate_hz": 200.0, "controller.kp": 0.5},
    "rate of 20 kHz": {"controller.rate_hz": 20000.0, "controller.delay_s": 70e-6},
    "constants": {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant(offset_n=0.1)},
    "sines": {
        "setpoint": fl.Sine(offset_n=0.58, amplitude_n=0.18, frequency_hz=17.0),
        "disturbance": fl.Sine(offset_n=0.15, amplitude_n=0.15, frequency_hz=60.0),
    },
    "steps": {
        "setpoint": fl.Steps(times_s=(0.0, 0.05, 0.10003), levels_n=(0.3, 0.7, 0.5)),
        "disturbance": fl.Steps(times_s=(0.0, 0.06, 0.12), levels_n=(0.1, 0.3, 0.0)),
    },
    "a swept disturbance": {
        "setpoint": fl.Constant(offset_n=0.6),
        "disturbance": fl.LogSweep(offset_n=0.2, amplitude_n=0.1, start_hz=100.0, stop_hz=2.0, sweep_s=0.25),
        "controller.delay_s": 100e-6,
    },
    "coloured noise": {
        "setpoint": fl.ColouredNoise(offset_n=0.5, rms_n=0.05, exponent=2.0, low_hz=2.0, high_hz=50.0),
        "disturbance": fl.ColouredNoise(offset_n=0.2, rms_n=0.05, exponent=1.0),
        "controller.delay_s": 120e-6,
    },
}


@pytest.fixture
def recording(tmp_path):
    """A recorded force at the loop's rate, on the boundaries of periods, with a corner at each sample."""
    path = tmp_path / "finger.csv"
    t = np.arange(3000) / 5000.0
    np.savetxt(path, 0.2 + 0.1 * np.sin(2 * np.pi * 40 * t) ** 3 + 0.02 * normals(5, 9, 0, t.size))
    return fl.Recording(path=str(path), rate_hz=5000.0)


def compare(system, duration_s, seed=0):
    run, exact = fl.simulate(system, duration_s, seed), solve(system, duration_s, seed)
    for name in ("f_r", "d"):  # no dynamics: phases of up to 2 pi * 215 turns, rounded a few times at 2^-53 of that
        np.testing.assert_allclose(run[name].values, exact[name], rtol=0, atol=1e-11, err_msg=name)
    for name in ("f_a", "f_m"):
        np.testing.assert_allclose(run[name].values, exact[name], rtol=0, atol=CHECKED_N, err_msg=name)
    # The command answers the measurement with gain kp; da/du = 1/(2 tau a u) has no bound near a = 0, so for the
    # amplitude its square is compared: d(a^2)/du = 1/(tau u), at most 36 um^2/N at the clamp.
    gain = max(1.0, system.controller.kp)
    np.testing.assert_allclose(run["u"].values, exact["u"], rtol=0, atol=gain * CHECKED_N)
    np.testing.assert_allclose(run["a"].values ** 2, exact["a"] ** 2, rtol=0, atol=36 * gain * CHECKED_N)
    # A command may touch its clamp within the error, and only then may the two disagree on that.
    differ = run["saturated"].values != exact["saturated"].astype(bool)
    assert differ.mean() < 1e-3
    return run


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_traces(name):
    system = fl.paper().evolve(LIVELY).evolve(CASES[name])
    fast = system.sensor.cutoff_hz > 5000 or system.controller.rate_hz > 5000  # many steps of the solver
    compare(system, 0.05 if fast else SHORT_S, seed=7)


@pytest.mark.soak
@pytest.mark.timeout(600)
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("base", [fl.paper, fl.feasible], ids=["paper", "feasible"])
def test_longer_traces(base, name):
    faster = {"setpoint.sweep_s": 1.0, "disturbance.frequency_hz": 3.0}
    system = base().evolve(faster).evolve(CASES[name])
    swept = [source.sweep_s for source in (system.setpoint, system.disturbance) if source.kind == "log_sweep"]
    compare(system, min([1.0, *swept]), seed=8)


@pytest.mark.parametrize("delay_s", [0.0, 90e-6])
def test_a_recorded_disturbance_and_set_point(recording, delay_s):
    system = fl.paper().evolve(
        {
            "disturbance": recording,
            "setpoint": recording.model_copy(update={"offset_n": 0.3}),
            "controller.delay_s": delay_s,
        }
    )
    compare(system, SHORT_S)


def test_the_fastest_disturbance():
    """At half the control rate six nodes a period are at their end: the promise is 1e-6 N."""
    system = fl.paper().evolve(LIVELY | {"disturbance.frequency_hz": 2500.0})
    error = fl.simulate(system, 0.1)["f_a"].values - solve(system, 0.1)["f_a"]
    assert np.abs(error).max() < 1e-6


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    "base",
    [pytest.param(fl.paper, marks=pytest.mark.slow), pytest.param(fl.feasible, marks=pytest.mark.soak)],
    ids=["paper", "feasible"],
)
def test_the_papers_run_from_beginning_to_end(base):
    compare(base(), 10.0)


def test_the_solver_has_converged(monkeypatch):
    system = fl.paper().evolve(LIVELY | NOISY | {"controller.delay_s": 37e-6})
    usual = solve(system, 0.05)["f_a"]
    monkeypatch.setitem(solve.__globals__, "RTOL", 1e-9)
    looser = solve(system, 0.05)["f_a"]
    # Loosening the tolerance a thousandfold moves it by less than a tenth of what is checked, and by something.
    assert 0 < np.abs(looser - usual).max() < CHECKED_N / 10


def statistics(traces):
    f_a, f_r, u = (np.asarray(traces[name], dtype=float) for name in ("f_a", "f_r", "u"))
    e = f_a - f_r
    return np.array(
        [
            1 - e @ e / np.sum((f_r - f_r.mean()) ** 2),
            math.sqrt(e @ e / e.size),
            np.mean(np.asarray(traces["saturated"], dtype=float)),
            np.abs(np.diff(u)).mean(),
            math.sqrt(np.mean(np.diff(f_a) ** 2)),
        ]
    )


def test_statistics_of_the_limit_cycle():
    """At kp = 40 traces diverge; the solver's run must look like one more of the simulator's seeds."""
    system = fl.feasible().evolve(LIVELY | {"controller.kp": 40.0, "setpoint.sweep_s": 0.5})
    exact = solve(system, 0.5, seed=3)
    run = fl.simulate(system, 0.5, seed=3)
    assert np.abs(run["f_a"].values - exact["f_a"]).max() > 0.01  # or traces could be compared after all
    seeds = np.array([statistics(fl.simulate(system, 0.5, seed)) for seed in range(100, 164)])
    spread = seeds.std(axis=0, ddof=1)
    assert np.all(spread < 0.02 * np.abs(seeds.mean(axis=0)))  # narrow enough to tell a wrong loop from a right one
    # 5 standard deviations: 1 in 10^5 per number for 64 seeds (Student's t), for a seed nobody chose.
    assert np.all(np.abs(statistics(exact) - seeds.mean(axis=0)) < 5 * spread)
