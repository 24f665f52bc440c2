"""Any control law in the linear analysis: against the simulator, the closed form of PI, and scipy's filters."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH
from scipy.signal import freqz
from steady_finger import SILENT, SLIDING

import frictionloop as fl
from frictionloop.analysis import LinearLoop, linearise
from frictionloop.analysis import controller_rest as resting
from frictionloop.analysis.controller_rest import rest_of
from frictionloop.analysis.law_space import jacobian_space, pi_space
from frictionloop.analysis.stability import rings
from frictionloop.control.law import Clamp, ForceCommand, Law, clamp_of
from frictionloop.quantities.scalar_math import step

# A response is measured about a point, with a signal that is small on purpose.
pytestmark = pytest.mark.filterwarnings("ignore:UNIT-DOUBT:frictionloop.SignalWarning")

RATE_HZ, TS = 5000, 1 / 5000
SETTLE_S, SCORE_S = 3.0, 1.0
STEADY = SLIDING | SILENT
"""A finger that slides steadily and a sensor without noise: what is left of the bench is what is linearised."""
TONES_HZ = np.array([3, 17, 41, 89, 137, 149, 211, 307, 499])
"""Whole periods in SCORE_S, on both sides of the resonance."""
MEAN_N, MEAN_D_N = 0.6, 0.05
OPEN = {"kind": "lookup", "delay_s": 200e-6}
LAWS: dict[str, dict[str, Any]] = {
    "pi": fl.RETUNED,
    "pi, late by a fraction": {"controller.kp": 0.02, "controller.ki": 50.0, "controller.delay_s": 1.3e-4},
    "notch_pi": {**DESIGNED_NOTCH, "controller.overdrive": False, "controller.feedforward": False},
    "notch_pi, overdrive and feed-forward": dict(DESIGNED_NOTCH),
    "limit_observer": {"controller.kind": "limit_observer"},
    "lookup": {"controller": OPEN},
    "lookup with overdrive": {"controller": OPEN | {"overdrive": True}},
}
"""Every law that is smooth, as overrides of the bench; a new law is one more row."""


def steady(changes: dict[str, Any], **signals: object) -> fl.System:
    constants = {"setpoint": fl.Constant(offset_n=MEAN_N), "disturbance": fl.Constant(offset_n=MEAN_D_N)}
    system = fl.bench()
    if isinstance(changes.get("controller"), dict):
        model = system.controller.model.model_dump()
        changes = changes | {"controller": {"model": model} | changes["controller"]}
    return system.evolve(STEADY | constants | changes | signals)


def lines(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.fft.rfft(values)[np.round(TONES_HZ * SCORE_S).astype(int)])


def driven(changes: dict[str, Any], where: str, folder: Path, amplitude_n: float = 1e-4) -> dict[str, np.ndarray]:
    """Return every force over the input at the tones, from the discrete Fourier transform of the scored second."""
    t = np.arange(round((SETTLE_S + SCORE_S) * RATE_HZ) + 2) / RATE_HZ
    phases = np.random.default_rng(5).uniform(0, 2 * np.pi, TONES_HZ.size)
    signal = amplitude_n * np.cos(2 * np.pi * np.outer(t, TONES_HZ) + phases).sum(axis=1)
    np.savetxt(folder / "tones.csv", signal, fmt="%.17g", header="force", comments="")
    mean = MEAN_N if where == "setpoint" else MEAN_D_N
    recording = fl.Recording(path=str(folder / "tones.csv"), column="force", rate_hz=RATE_HZ, offset_n=mean)
    run = fl.simulate(steady(changes, **{where: recording}), duration_s=SETTLE_S + SCORE_S, seed=0)
    scored = slice(round(SETTLE_S * RATE_HZ), round((SETTLE_S + SCORE_S) * RATE_HZ))
    assert not run.saturated[scored].any()
    given = lines(signal[:-2][scored])
    return {name: lines(run[name].values[scored]) / given for name in ("f_a", "f_m", "u")}


def where_it_runs(changes: dict[str, Any]) -> LinearLoop:
    """Return the loop at the force where the simulated one rests: a lookup alone leaves the disturbance."""
    system = steady(changes)
    return linearise(system, force_n=MEAN_N - (0.0 if system.controller.kind == "lookup" else MEAN_D_N))


@pytest.mark.slow
@pytest.mark.parametrize("name", LAWS)
def test_responses(name: str, tmp_path: Path) -> None:
    """From set-point and disturbance to both forces and the command; asked for: 5 %."""
    loop = where_it_runs(LAWS[name])
    expected = loop.state_space().response(TONES_HZ)
    for column, where in enumerate(("setpoint", "disturbance")):
        measured = driven(LAWS[name], where, tmp_path)
        for row, output in enumerate(("f_a", "f_m", "u")):
            wanted = expected[:, row, column]
            np.testing.assert_allclose(measured[output], wanted, rtol=0.02, atol=1e-9, err_msg=f"{output} from {where}")


@pytest.mark.parametrize("name", [name for name in LAWS if "lookup" not in name])
def test_sensitivities(name: str, tmp_path: Path) -> None:
    """S is what the loop leaves of a disturbance in f_m, over what the lookup alone leaves; T is the rest: 5 %."""
    loop = where_it_runs(LAWS[name])
    # The open loop is brought to where the closed one rests: set-point less disturbance.
    open_loop = {"controller": OPEN, "setpoint.offset_n": MEAN_N - MEAN_D_N}
    closed, left = (driven(changes, "disturbance", tmp_path)["f_m"] for changes in (LAWS[name], open_loop))
    expected = loop.responses(TONES_HZ)
    np.testing.assert_allclose(np.abs(closed / left), np.abs(expected["S"]), rtol=0.02)
    np.testing.assert_allclose(np.abs(1 - closed / left), np.abs(expected["T"]), rtol=0.05)


@pytest.mark.parametrize(
    "gains", [fl.RETUNED, {}, {"controller.ki": 0.0}, {"controller.kp": 0.0}, {"controller.model.table_size": 64}]
)
@pytest.mark.parametrize("preset", ["paper", "bench"])
def test_jacobian_of_pi(gains: dict[str, float], preset: str) -> None:
    """The compiled step, linearised, is the closed form; also where the loop is unstable, and of gains that are 0."""
    system = getattr(fl, preset)().evolve(gains)
    loop, pi = linearise(system), system.controller
    found, wanted = jacobian_space(rest_of(system, loop.elements, loop.plant)), pi_space(pi.kp, pi.ki, TS)
    for name in "ABCD":
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), rtol=1e-9, atol=1e-12)


B, A = (0.31, -0.42, 0.17), (1.0, -1.52, 0.61)
"""A biquad with a gain of 2/3 at 0 and poles at 0.76 +- 0.18j (chosen)."""
GAIN = 0.04


class BiquadState(NamedTuple):
    integral: float
    s1: float
    s2: float
    command: float
    estimate: float


class OneGain(NamedTuple):
    gain: float
    low: float
    high: float


@step
def _biquad_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    """I += k e; u = biquad(I) - log-like bend of what is measured: two inputs, a nonlinear path, an estimate."""
    integral, s1, s2, _, estimate = state
    gain, low, high = gains
    integral += gain * (setpoint_n - measurement.force)
    y = B[0] * integral + s1
    s1, s2 = B[1] * integral - A[1] * y + s2, B[2] * integral - A[2] * y
    wanted = estimate * y - 0.3 * measurement.force * measurement.force + 0.2 * setpoint_n
    u = min(max(wanted, low), high)
    after = BiquadState(integral, s1, s2, u, estimate)
    return after, ForceCommand(u, 1.0 if u != wanted else 0.0)


BIQUAD = Law(
    "lookup",
    _biquad_step,
    BiquadState,
    OneGain,
    gains_of=lambda c: OneGain(GAIN, *clamp_of(c.model)),
    start_of=lambda c: BiquadState(0.0, 0.0, 0.0, 0.0, 1.5),
)


def with_law(monkeypatch: pytest.MonkeyPatch, law: Law, changes: dict[str, Any] | None = None) -> LinearLoop:
    """Return the loop of a law that is in no registry."""
    monkeypatch.setattr(resting, "law_of", lambda controller: law)
    return linearise(steady(LAWS["lookup"] | (changes or {})))


def test_biquad_against_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    """C_y = 1.5 k z^-1/(1 - z^-1) biquad + 2 0.3 f_m, C_r = the same + 0.2; the last u dropped, the estimate held."""
    loop = with_law(monkeypatch, BIQUAD)
    frequency = np.geomspace(1, 2400, 50)
    z = np.exp(2j * np.pi * frequency * TS)
    _, filtered = freqz(B, A, worN=2 * np.pi * frequency * TS)
    feedback = 1.5 * GAIN * filtered / (1 - 1 / z)  # the sum as it is after this period's error
    C = loop.law.response(frequency)[:, 0]
    np.testing.assert_allclose(C[:, 0], feedback + 0.2, rtol=1e-6)
    np.testing.assert_allclose(C[:, 1], -feedback - 0.6 * 0.55 - 0.6 * MEAN_D_N, rtol=1e-6)
    assert len(loop.law.A) == 3


def test_it_rests_where_the_operating_point_is(monkeypatch: pytest.MonkeyPatch) -> None:
    """Force and command are those of the point, and a step from there changes nothing."""
    loop = with_law(monkeypatch, BIQUAD)
    rest = rest_of(loop.system, loop.elements, loop.plant)
    assert rest.point[-1] == pytest.approx(loop.elements.force_n + MEAN_D_N)
    np.testing.assert_allclose(rest.step(rest.point)[:-1], rest.point[:-2], atol=1e-9)
    assert rest.step(rest.point)[-1] == pytest.approx(loop.elements.force_n)  # the model is right


class CountingState(NamedTuple):
    integral: float
    count: float


@step
def _counting_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    """An integral that starts 100 periods late: no search from the start finds its rest, a run does."""
    integral, count = state
    low, high = gains
    integral += (0.02 if count > 99.5 else 0.0) * (setpoint_n - measurement.force)
    return CountingState(integral, min(count + 1.0, 100.0)), ForceCommand(min(max(integral, low), high), 0.0)


def test_a_law_that_wakes_up_late(monkeypatch: pytest.MonkeyPatch) -> None:
    loop = with_law(monkeypatch, Law("lookup", _counting_step, CountingState, Clamp))
    frequency = np.array([1.0, 30.0, 2000.0])
    z = np.exp(2j * np.pi * frequency * TS)
    np.testing.assert_allclose(
        loop.responses(frequency)["u_from_q"] / loop.responses(frequency)["S"], -0.02 / (1 - 1 / z)
    )


class OneState(NamedTuple):
    value: float


@step
def _twisting_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    (integral,) = state
    low, high = gains
    error = setpoint_n - measurement.force
    sign = 1.0 if error > 0.0 else (-1.0 if error < 0.0 else 0.0)
    u = integral + 0.1 * sign * np.sqrt(abs(error))
    return OneState(integral + 1e-3 * sign), ForceCommand(min(max(u, low), high), 0.0)


@step
def _kinked_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    (integral,) = state
    low, high = gains
    error = setpoint_n - measurement.force
    integral += 0.02 * error
    return OneState(integral), ForceCommand(min(max(integral + 0.1 * abs(error), low), high), 0.0)


@step
def _graded_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    """A kink that goes by the width of the clamp: without one it would not be seen."""
    (integral,) = state
    low, high = gains
    error = setpoint_n - measurement.force
    integral += 0.02 * error
    return OneState(integral), ForceCommand(min(max(integral + 0.1 / (high - low) * abs(error), low), high), 0.0)


@step
def _running_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    (time,) = state
    low, high = gains
    return OneState(time + dt), ForceCommand(min(max(setpoint_n, low), high), 0.0)


@step
def _stopped_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    low, high = gains
    u = min(max(setpoint_n, low), high)
    return state, ForceCommand(u, 1.0 if u > 0.5 else 0.0)


@pytest.mark.parametrize(
    ("law_step", "says"),
    [
        (_twisting_step, "not smooth"),
        (_kinked_step, "not smooth"),
        (_graded_step, "not smooth"),
        (_running_step, "no rest at 0.55 N"),
        (_stopped_step, "saturated at 0.55 N"),
    ],
)
def test_what_has_no_linear_analysis_is_refused(monkeypatch: pytest.MonkeyPatch, law_step: Any, says: str) -> None:
    loop = with_law(monkeypatch, Law("lookup", law_step, OneState, Clamp))
    with pytest.raises(fl.FrictionloopError, match=rf'^controller\.kind = "lookup": [^\n]*{says}[^\n]*$'):
        loop.is_stable()


@pytest.mark.parametrize("force_n", ["floor", "above f0"])
def test_at_the_edge_of_its_clamp_a_law_has_the_feedback_of_its_inside(force_n: str) -> None:
    """Where the least force is asked for, or more than f0, overdrive of the expected reading is clipped to one side."""
    system = steady(dict(DESIGNED_NOTCH), disturbance=fl.Constant(offset_n=0.0))
    if force_n == "above f0":
        at = system.evolve({"friction.nominal_n": 1.5 * system.controller.model.nominal_n})
        edge = linearise(at, force_n=1.1 * system.controller.model.nominal_n)
    else:
        edge = linearise(system, force_n=system.controller.model.floor_n)
    frequency = np.array([2.0, 40.0, 145.0, 900.0])
    found, inside = (loop.law.response(frequency)[:, 0, 1] for loop in (edge, linearise(system, force_n=MEAN_N)))
    np.testing.assert_allclose(found, inside, rtol=1e-6)


def test_overdrive_is_the_inverse_of_the_plate() -> None:
    """Behind it the plate's amplitude is the wanted one a period later: command to force is z^-1 without delay."""
    system = fl.paper().evolve({"controller": {"kind": "lookup", "overdrive": True}})
    frequency = np.geomspace(1, 2500, 40)
    response = linearise(system).responses(frequency)
    np.testing.assert_allclose(response["f_a_from_f_r"], np.exp(-2j * np.pi * frequency * TS), rtol=1e-9)
    np.testing.assert_array_equal(response["G"], 0.0)


def test_lookup_alone_has_no_feedback() -> None:
    loop = linearise(steady(LAWS["lookup"]))
    margins = loop.margins()
    assert loop.is_stable() and margins.sensitivity_peak == 1.0 and margins.gain_margin == np.inf
    assert fl.output_noise_rms_n(loop) == 0.0


@pytest.mark.parametrize(
    "ask",
    [
        lambda loop: loop.with_gains(1.0, 2.0),
        fl.kp_limit,
        lambda loop: fl.retune([loop]),
        lambda loop: loop.responses(10.0, "held"),
    ],
)
def test_what_is_for_pi_says_so(ask: Any) -> None:
    with pytest.raises(fl.FrictionloopError, match=r'^[^\n]*controller\.kind = [^\n]*"pi"[^\n]*$'):
        ask(linearise(steady(LAWS["lookup"])))


@step
def _integral_step(state, measurement, setpoint_n, gains, dt):  # type: ignore[no-untyped-def]
    (integral,) = state
    gain, low, high = gains
    integral += gain * (setpoint_n - measurement.force)
    return OneState(integral), ForceCommand(min(max(integral, low), high), 0.0)


@pytest.mark.parametrize(("gain", "how"), [(0.005, "calm"), (0.08, "near"), (0.1, "unstable")])
def test_a_law_without_kp_rings_or_not(monkeypatch: pytest.MonkeyPatch, gain: float, how: str) -> None:
    law = Law("lookup", _integral_step, OneState, OneGain, lambda c: OneGain(gain, *clamp_of(c.model)))
    loop = with_law(monkeypatch, law)
    found = rings(loop.system)
    assert found.how == how
    assert found.sensitivity_peak >= loop.margins().sensitivity_peak
