"""Control laws, friction laws, signals and metrics from outside: they run as those of the package do, in every use."""

from __future__ import annotations

import importlib
import importlib.util
import math
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.analysis.loop_elements import lumped_gain
from frictionloop.control.lookup import lookup_table
from frictionloop.design.comparison.trial_protocol import entrants
from frictionloop.loop.registered_blocks import forget, outside_digest
from frictionloop.quantities.scalar_math import fma

BENCH = fl.bench().evolve(fl.RETUNED)
GAINS = {path: fl.RETUNED[path] for path in ("controller.kp", "controller.ki")}
KPS = {"controller.kp": [0.05, 0.062, 0.07]}


class State(NamedTuple):
    integral: float


class Gains(NamedTuple):
    kp: float
    ki: float
    low: float
    high: float


class OwnPi(fl.Timing):
    kind: Literal["own_pi"] = "own_pi"
    kp: float = 10.0
    ki: float = 2.0


class PythonPi(OwnPi):
    kind: Literal["python_pi"] = "python_pi"


def pi(state, measured, setpoint_n, gains, dt):
    """The built-in PI, written again."""
    kp, ki = measured.valid * gains.kp, measured.valid * gains.ki
    error = setpoint_n - measured.force
    v = fma(kp, error, state.integral)
    u = min(max(v, gains.low), gains.high)
    pushes = ((v > gains.high) & (error > 0.0)) | ((v < gains.low) & (error < 0.0))
    integral = state.integral if pushes else fma(ki * dt, error, state.integral)
    return State(integral), fl.ForceCommand(u, 1.0 if v != u else 0.0)


def python_pi(state, measured, setpoint_n, gains, dt):
    """The same without compiled parts."""
    kp, ki = measured.valid * gains.kp, measured.valid * gains.ki
    error = setpoint_n - measured.force
    v = kp * error + state.integral
    u = min(max(v, gains.low), gains.high)
    pushes = (v > gains.high and error > 0.0) or (v < gains.low and error < 0.0)
    integral = state.integral if pushes else state.integral + ki * dt * error
    return State(integral), fl.ForceCommand(u, 1.0 if v != u else 0.0)


@fl.step
def begin(state, force_n, setpoint_n, gains):
    return State(force_n)


class Exponential(fl.FingerFriction):
    """F_max 2^(-a / halving)."""

    kind: Literal["exponential"] = "exponential"
    halving_um: float = 0.7


class Halving(NamedTuple):
    per_um: float


@fl.step
def halved(amplitude_um, occluded, coefficients):
    return 2.0 ** (-amplitude_um * coefficients.per_um)


class Ramp(fl.Signal):
    kind: Literal["ramp"] = "ramp"
    start_n: float = 0.5
    rise_n: float = 0.01

    def force_n(self, time_s):
        return self.start_n + self.rise_n * time_s


class Largest(NamedTuple):
    error: float


@fl.step
def largest(state, sample, dt):
    return Largest(max(state.error, abs(sample.f_a - sample.f_r)))


OWN_LAW = fl.Law("own_pi", fl.step(pi), State, Gains, begin=begin)
FRICTION = fl.Vibration("exponential", halved, Halving, lambda f: Halving(1.0 / f.halving_um))
LARGEST = fl.StreamingMetric("largest_error", largest, Largest, lambda state, count: state.error, "N")


@pytest.fixture(autouse=True)
def _forgotten():
    yield
    forget()


@pytest.fixture
def own():
    """The bench with the PI from outside."""
    fl.register(OWN_LAW, OwnPi)
    return BENCH.evolve({"controller.kind": "own_pi", **GAINS})


@pytest.fixture
def sticky():
    """The bench under a friction law from outside."""
    fl.register(FRICTION, Exponential)
    return BENCH.evolve({"friction.kind": "exponential"})


def test_a_pi_from_outside_gives_the_bits_of_the_built_in(own):
    for override in ({}, {"controller.open_until_s": 0.02}, {"controller.jitter_s": 2e-5}):
        xr.testing.assert_equal(fl.simulate(own.evolve(override), 0.2), fl.simulate(BENCH.evolve(override), 0.2))
    assert fl.sweep(own, KPS, 0.2).equals(fl.sweep(BENCH, KPS, 0.2))


def test_a_sweep_gives_what_single_runs_give(own):
    fl.register(LARGEST)
    fl.register(fl.RunMetric("p95", lambda run: np.percentile(abs(run.f_a - run.f_r), 95), "N"))
    swept = fl.sweep(own, KPS, 0.2, metrics=["rms_error", "largest_error", "p95"])
    runs = [fl.simulate(own.evolve({"controller.kp": kp}), 0.2) for kp in KPS["controller.kp"]]
    errors = np.array([abs(run.f_a - run.f_r) for run in runs])
    scored = np.where([run.scored > 0 for run in runs], errors, 0.0)
    np.testing.assert_array_equal(swept.largest_error[:, 0], scored.max(axis=1))
    np.testing.assert_array_equal(swept.p95[:, 0], np.percentile(errors, 95, axis=1))
    np.testing.assert_allclose(swept.rms_error[:, 0], [fl.rms_error(run) for run in runs], rtol=1e-12)


def test_the_linear_analysis_of_a_pi_from_outside_is_that_of_the_built_in(own):
    mine, theirs = fl.linearise(own).margins(), fl.linearise(BENCH).margins()
    for name in ("gain_margin", "phase_margin_deg", "delay_margin_s", "crossover_hz", "modulus_margin"):
        assert getattr(mine, name) == pytest.approx(getattr(theirs, name), rel=1e-4), name
    assert mine.stable
    assert theirs.stable


class Halved(fl.PiController):
    kind: Literal["halved"] = "halved"  # type: ignore[assignment]


def test_parameters_that_inherit_from_pi_are_linearised_by_their_own_step():
    law = fl.Law("halved", fl.step(pi), State, Gains, lambda c: Gains(c.kp / 2, c.ki / 2, *fl.clamp_of(c.model)))
    fl.register(law, Halved)
    mine = fl.linearise(BENCH.evolve({"controller.kind": "halved", "controller.kp": 0.12, "controller.ki": 260.0}))
    theirs = fl.linearise(BENCH.evolve({"controller.kp": 0.06, "controller.ki": 130.0}))
    assert mine.margins().sensitivity_peak == pytest.approx(theirs.margins().sensitivity_peak, rel=1e-6)
    with pytest.raises(fl.FrictionloopError, match=r'controller\.kind = "halved": .*"pi"'):
        mine.with_gains(0.1, 100.0)


def test_a_law_in_plain_python_gives_what_it_gives_compiled():
    fl.register(fl.Law("own_pi", fl.step(python_pi), State, Gains), OwnPi)
    with pytest.warns(UserWarning, match=rf'law "python_pi": {__file__}, line \d+: .*@fl.step'):
        fl.register(fl.Law("python_pi", python_pi, State, Gains), PythonPi)
    systems = [BENCH.evolve({"controller.kind": kind, **GAINS}) for kind in ("own_pi", "python_pi")]
    compiled, plain = (fl.simulate(system, 0.05) for system in systems)
    for name in compiled:
        np.testing.assert_allclose(plain[name], compiled[name], rtol=0, atol=1e-12, err_msg=name)
    compiled, plain = (fl.sweep(system, KPS, 0.02) for system in systems)
    xr.testing.assert_allclose(compiled, plain, rtol=1e-12)


MODULE = """
import frictionloop as fl
from typing import NamedTuple
class Total(NamedTuple):
    force: float
@fl.step
def total(state, sample, dt):
    return Total(state.force + dt * sample.u)
METRIC = fl.StreamingMetric("total", total, Total, lambda state, count: state.force)
"""


def test_code_that_moved_to_another_module_runs_although_the_disk_has_it_from_the_first(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    values = []
    for name in ("first_home_of_a_metric", "second_home_of_a_metric"):
        (tmp_path / f"{name}.py").write_text(MODULE, encoding="utf-8")
        fl.register(importlib.import_module(name).METRIC)
        values.append(fl.sweep(BENCH, {"controller.kp": [0.06]}, 0.2, metrics=["total"]).total.item())
        del sys.modules[name]
        (tmp_path / f"{name}.py").unlink()
    assert values[0] == values[1] > 0.0


def test_a_comparison_takes_a_law_from_outside_by_its_kind(own):
    assert set(fl.compare(own, ["own_pi"], 1, 5, [20.0], duration_s=1.5).runs.laws) == {"own_pi"}


def test_files_keep_blocks_from_outside(own, sticky, tmp_path):
    fl.register(Ramp)
    system = own.evolve({"friction.kind": "exponential", "setpoint.kind": "ramp", "setpoint.rise_n": 0.02})
    fl.write_toml(system, tmp_path / "mine.toml")
    assert fl.read_toml(tmp_path / "mine.toml") == system
    fl.save(fl.simulate(system, 0.01), tmp_path / "run.h5")
    assert fl.system_of(fl.load(tmp_path / "run.h5")) == system
    forget()
    for read in (lambda: fl.read_toml(tmp_path / "mine.toml"), lambda: fl.system_of(fl.load(tmp_path / "run.h5"))):
        with pytest.raises(fl.FrictionloopError, match=r"kind = '\w+' is unknown; .*fl\.register"):
            read()


def test_another_code_is_another_sweep(own, tmp_path, monkeypatch):
    path, options = tmp_path / "sweep.h5", {"duration_s": 0.01}
    first = fl.sweep(own, KPS, path=path, **options)
    before = outside_digest()
    monkeypatch.setitem(globals(), "valid", 3.0)  # a global that is called as a field the law reads
    assert outside_digest() == before
    assert fl.sweep(own, KPS, path=path, resume=True, **options).attrs["fingerprint"] == first.attrs["fingerprint"]

    @fl.step
    def doubled(state, measured, setpoint_n, gains, dt):
        return state, fl.ForceCommand(min(max(2.0 * setpoint_n, gains.low), gains.high), 0.0)

    fl.register(fl.Law("own_pi", doubled, State, Gains), OwnPi)
    assert outside_digest() != before
    with pytest.raises(fl.FrictionloopError, match="sweep"):
        fl.sweep(own, KPS, path=path, resume=True, **options)


def test_a_friction_law_from_outside_is_felt_inverted_and_linearised(sticky):
    friction = sticky.friction
    np.testing.assert_allclose(fl.friction_force([0.0, 0.7, 1.4], friction), friction.nominal_n * 0.5 ** np.arange(3))
    wanted = np.array([0.2, 0.5, 0.9])
    inverted = fl.amplitude_for(wanted, friction)
    np.testing.assert_allclose(inverted, -0.7 * np.log2(wanted / friction.nominal_n), atol=1e-8)
    assert fl.reachable(sticky).low_n == pytest.approx(friction.nominal_n * 2 ** (-2.5 / 0.7), rel=1e-6)
    # dg/d(a^2) of the exponential is -g ln 2/(2 a h); what the lookup believes is divided out.
    amplitude, model = 1.0, sticky.controller.model
    gain = lumped_gain(sticky, amplitude)
    force = fl.linearise(sticky, amplitude_um=amplitude).elements.force_n
    believed = model.nominal_n * np.exp(-model.susceptibility_per_um2 * amplitude**2)
    slope = force * np.log(2.0) / (2.0 * amplitude * friction.halving_um)
    assert gain == pytest.approx(slope / (model.susceptibility_per_um2 * believed), rel=1e-5)


def test_a_friction_law_from_outside_spreads_with_the_fingers_susceptibility_and_moisture(sticky):
    # The built-in e^(-a sqrt(tau (1 - l w))) depends on the root of tau: the same halving, the same fingers.
    halving_um = math.log(2.0) / math.sqrt(0.38)
    own = sticky.evolve({"friction.halving_um": halving_um})
    built_in = BENCH.evolve({"friction.kind": "rough_contact"})
    people = fl.fingers(4, 1)
    got, wanted = (fl.sweep(each, people, duration_s=0.4).rms_error.values for each in (own, built_in))
    np.testing.assert_allclose(got, wanted, rtol=1e-6)
    assert np.ptp(got) > 0.1 * got.mean()


def test_a_calibrated_lookup_commands_the_force_of_a_law_from_outside(sticky):
    still = sticky.evolve({"friction.halving_um": 1.1})
    believed = fl.calibrate(still, table_size=512).controller.model
    table = lookup_table(believed)
    forces = np.linspace(believed.floor_n, believed.nominal_n, 512)
    np.testing.assert_allclose(fl.friction_force(np.sqrt(table), still.friction), forces, rtol=1e-6)


def test_calibrating_a_bench_that_is_known_changes_nothing_and_mends_what_is_not():
    assert fl.calibrate(BENCH) == BENCH.evolve({"controller.model.nominal_n": BENCH.friction.nominal_n})
    wrong = {"plate.q": 460.0, "sensor.resonance_hz": 120.0, "friction.susceptibility_per_um2": 0.5}
    model = fl.calibrate(BENCH.evolve(wrong)).controller.model
    assert (model.plate_hz, model.resonance_hz, model.susceptibility_per_um2) == (50.0, 120.0, 0.5)
    with pytest.raises(fl.FrictionloopError, match="table_size = 1: "):
        fl.calibrate(BENCH, table_size=1)


def test_a_signal_is_what_its_function_says_and_samples_are_linear_between():
    fl.register(Ramp)
    f_r = fl.simulate(BENCH.evolve({"setpoint.kind": "ramp", "setpoint.rise_n": 0.2}), 0.1).f_r
    np.testing.assert_allclose(f_r, 0.5 + 0.2 * f_r.time)
    samples = fl.Samples(values_n=np.array([0.5, 0.7, 0.6]), rate_hz=100.0)
    f_r = fl.simulate(BENCH.evolve({"setpoint": samples}), 0.02).f_r
    np.testing.assert_allclose(f_r[[0, 25, 50, 75]], [0.5, 0.6, 0.7, 0.65])


SCRIPT = """
import warnings
from typing import Literal, NamedTuple
import joblib, numpy as np
import frictionloop as fl

class Mine(fl.Timing):
    kind: Literal["mine"] = "mine"
    kp: float = 0.0
    ki: float = 111.0
class State(NamedTuple):
    integral: float
class Gains(NamedTuple):
    kp: float
    ki: float
    low: float
    high: float
@fl.step
def mine(state, measured, setpoint_n, gains, dt):
    e = measured.valid * (setpoint_n - measured.force)
    v = gains.kp * e + state.integral
    u = min(max(v, gains.low), gains.high)
    return State(state.integral + gains.ki * dt * e), fl.ForceCommand(u, 1.0 if u != v else 0.0)
fl.register(fl.Law("mine", mine, State, Gains), Mine)
class Ramp(fl.Signal):
    kind: Literal["ramp"] = "ramp"
    def force_n(self, time_s):
        return 0.5 + 0.1 * time_s
fl.register(Ramp)
class Most(NamedTuple):
    most: float
@fl.step
def most(state, sample, dt):
    return Most(max(state.most, sample.u))
fl.register(fl.StreamingMetric("most", most, Most, lambda state, count: state.most))
fl.register(fl.RunMetric("mean", lambda run: run.f_a.mean()))

if __name__ == "__main__":
    system = fl.bench().evolve({"controller.kind": "mine", "setpoint.kind": "ramp"})
    call = system, {"controller.kp": np.linspace(0.05, 0.07, 70)}, 0.3, 1, ["rms_error", "most"]
    near = fl.sweep(*call)
    mean = fl.sweep(system, {"controller.kp": [0.05, 0.07]}, 0.3, 1, ["mean"])
    BACKEND
        far = fl.sweep(*call, n_jobs=2)
        far_mean = fl.sweep(system, {"controller.kp": [0.05, 0.07]}, 0.3, 1, ["mean"], n_jobs=2)
    assert far.identical(near) and far_mean.identical(mean)
    print("the same")
"""
BACKENDS = {
    "loky": 'with joblib.parallel_config(backend="loky"):',
    "dask": """from dask.distributed import Client
    client = Client(n_workers=2, threads_per_worker=1, dashboard_address=":0")
    with client, joblib.parallel_config(backend="dask"):""",
}


@pytest.mark.slow
@pytest.mark.parametrize("backend", BACKENDS)
def test_other_processes_know_what_the_caller_registered(backend, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.replace("BACKEND", BACKENDS[backend]), encoding="utf-8")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False, timeout=280)
    assert done.stdout.strip() == "the same", textwrap.shorten(done.stderr, 3000)


@pytest.mark.slow
def test_every_process_gives_a_sweep_the_same_fingerprint(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.replace("BACKEND", "if True:"), encoding="utf-8")
    ask = "import runpy, sys; from frictionloop.loop.registered_blocks import outside_digest\n"
    ask += "runpy.run_path(sys.argv[1]); print(outside_digest())"
    told = {subprocess.check_output([sys.executable, "-c", ask, script], text=True) for _ in range(2)}
    assert len(told) == 1
    assert len(told.pop()) > 10


FILE = Path(__file__).parents[2] / "examples" / "sliding_mode.py"


@pytest.fixture
def example():
    spec = importlib.util.spec_from_file_location("sliding_mode", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_on_a_rigid_finger_the_mean_force_is_the_set_point(example):
    plain = {"finger.kind": "rigid", "disturbance": fl.Constant(offset_n=0.05), "setpoint": fl.Constant(offset_n=0.6)}
    run = fl.simulate(fl.bench().evolve({**plain, "controller.kind": "sliding_mode"}), 4.0)
    assert float(run.f_a[10_000:].mean()) == pytest.approx(0.6, abs=2e-3)


def test_the_step_is_implicit_and_ends_in_the_sliding_surface(example):
    """|s| <= k2 dt is taken away whole in a period; beyond it w moves by k2 dt, u by k1 (|s| - k2 dt)^(1/2) more."""
    gains, dt = example.Gains(0.02, 10.0, 0.1, 0.95), 2e-4
    for s in (1e-3, -1e-3, 0.01, -0.01):
        state, command = example.sliding_mode(
            example.State(-0.4), fl.Measurement(0.5 + s, 0, 0, 0, 1.0), 0.5, gains, dt
        )
        moved = -np.sign(s) * min(abs(s), 2e-3)
        assert state.w + 0.4 == pytest.approx(moved, abs=1e-12)
        beyond = np.sign(s) * 0.02 * np.sqrt(max(abs(s) - 2e-3, 0.0))
        assert command.u == pytest.approx(0.95 - 0.4 + moved - beyond, abs=1e-12)


def test_it_is_an_entrant_by_its_kind(example):
    assert list(entrants(["lookup", "sliding_mode"])) == ["lookup", "sliding_mode"]
