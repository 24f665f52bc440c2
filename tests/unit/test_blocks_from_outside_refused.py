"""Mistakes in blocks from outside: one line that names the block, the file and line, and what is accepted."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.registered_blocks import forget

BENCH = fl.bench().evolve(fl.RETUNED)
KPS = {"controller.kp": [0.05, 0.062, 0.07]}
HERE = rf"{__file__}, line \d+: "


class Mine(fl.Timing):
    kind: Literal["mine"] = "mine"
    kp: float = 0.06
    ki: float = 130.0


class State(NamedTuple):
    integral: float


class Gains(NamedTuple):
    kp: float
    ki: float
    low: float
    high: float


@fl.step
def held(state, measured, setpoint_n, gains, dt):
    return state, fl.ForceCommand(min(max(setpoint_n, gains.low), gains.high), 0.0)


class ClampFirst(NamedTuple):
    low: float
    high: float
    kp: float


class NoClamp(NamedTuple):
    kp: float


class OtherName(NamedTuple):
    kd: float
    low: float
    high: float


MANY = NamedTuple("MANY", [*((f"g{i}", float) for i in range(300)), ("low", float), ("high", float)])  # type: ignore[misc]


class Unhashable:
    __hash__ = None  # type: ignore[assignment]

    def __call__(self, *given):
        return State(0.0)


def nothing(*given):
    pass


def force_alone(state, measured, setpoint_n, gains, dt):
    return fl.ForceCommand(setpoint_n, 0.0)


def a_number(state, measured, setpoint_n, gains, dt):
    return state, setpoint_n


def two_states(state, measured, setpoint_n, gains, dt):
    return (0.0, 0.0), fl.ForceCommand(setpoint_n, 0.0)


def misspelt(state, measured, setpoint_n, gains, dt):
    return state, fl.ForceCommand(gains.kpp * setpoint_n, 0.0)


def four_arguments(state, measured, setpoint_n, gains):
    return state, fl.ForceCommand(setpoint_n, 0.0)


def not_a_number(state, measured, setpoint_n, gains, dt):
    return state, fl.ForceCommand(float("nan"), 0.0)


def raises(state, measured, setpoint_n, gains, dt):
    if setpoint_n > 10.0:
        raise ValueError("too high")
    return state, fl.ForceCommand(setpoint_n, 0.0)


LAWS: dict[str, tuple[dict[str, Any], str]] = {
    "gains in another order": ({"gains": ClampFirst}, "gains low, high, kp"),
    "no clamp": ({"gains": NoClamp}, "gains kp "),
    "a gain that is no parameter": ({"gains": OtherName}, "gain 'kd': .*kp, ki"),
    "too many gains": ({"gains": MANY, "gains_of": lambda c: MANY(*range(302))}, "1 states, 302 gains.* 256"),
    "gains of another shape": ({"gains_of": lambda c: (c.kp, c.ki)}, HERE + "gains_of .*Gains"),
    "gains that raise": ({"gains_of": lambda c: Gains(c.kq, 0, 0, 1)}, HERE + "AttributeError: .*'kq'"),
    "a state that is no class": ({"state": State(0.0)}, "state = State.*NamedTuple"),
    "a state that is no named tuple": ({"state": float}, "state = .*NamedTuple"),
    "a start of another shape": ({"start_of": lambda c: 0.0}, HERE + "start_of .*0.0; .*State"),
    "no function": ({"step": 3}, "step = 3: "),
    "no result": ({"step": nothing}, HERE + "step .*ForceCommand"),
    "a force command alone": ({"step": force_alone}, HERE + "step, .*state, .*0.6; .*State"),
    "a number for the command": ({"step": a_number}, HERE + "step, .*command, .*0.6; .*Force"),
    "a state of another size": ({"step": two_states}, HERE + "step, .*state, .*; .*State"),
    "a misspelt gain": ({"step": misspelt}, HERE + "AttributeError: .*'kpp'"),
    "too few arguments": ({"step": four_arguments}, "TypeError: four_arguments.. takes 4 positional arguments"),
    "not a number": ({"step": not_a_number}, HERE + "step, .*command, .*nan"),
    "compiled code that raises": ({"step": fl.step(raises)}, HERE),
    "a plain begin": ({"begin": lambda *given: State(0.0)}, HERE + "begin .*@fl.step"),
    "what cannot be a key": ({"start_of": Unhashable()}, "'Unhashable'"),
}


@pytest.fixture(autouse=True)
def _forgotten():
    yield
    forget()


@pytest.mark.filterwarnings("ignore:law")
@pytest.mark.parametrize("compiled", [False, True])
@pytest.mark.parametrize("mistake", LAWS)
def test_a_law_that_cannot_run_is_refused_when_it_is_registered(mistake, compiled):
    changed, told = LAWS[mistake]
    law = {"step": held, "state": State, "gains": Gains} | changed
    step = changed.get("step")
    if compiled and callable(step) and not hasattr(step, "py_func"):
        law["step"] = fl.step(step)
    with pytest.raises(fl.FrictionloopError, match=told) as refused:
        fl.register(fl.Law("mine", **law), Mine)
    assert "\n" not in str(refused.value)
    assert '"mine"' in str(refused.value)
    with pytest.raises(fl.FrictionloopError, match="kind = 'mine' is unknown"):
        BENCH.evolve({"controller.kind": "mine"})


class Nameless(fl.Timing):
    pass


class Pi(fl.Timing):
    kind: Literal["pi"] = "pi"


class Spaced(fl.Timing):
    kind: Literal["my law"] = "my law"


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ((fl.Law("mine", held, State, Gains),), r'Law "mine": register\(block, Parameters\)'),
        ((fl.Law("other", held, State, Gains), Mine), r'Law "other": register\(block, Parameters\)'),
        ((fl.Law("mine", held, State, Gains), Nameless), "Nameless: "),
        ((fl.Law("mine", held, State, Gains), "mine"), "'mine': "),
        ((fl.Law("pi", held, State, Gains), Pi), 'Pi.kind = "pi": '),
        ((fl.Law("my law", held, State, Gains), Spaced), 'Spaced.kind = "my law": '),
        ((Mine,), "Mine.*Law, Vibration, Signal"),
        ((held,), "held.*Law, Vibration, Signal"),
        (([1, 2],), r"\[1, 2\]: .*Law, Vibration, Signal"),
    ],
)
def test_what_is_no_block_is_refused(given, told):
    with pytest.raises(fl.FrictionloopError, match=told):
        fl.register(*given)


def test_a_kind_registered_again_is_replaced():
    fl.register(fl.Law("mine", held, State, Gains), Mine)
    fl.register(fl.Law("mine", held, State, Gains, begin=None), Mine)
    assert BENCH.evolve({"controller.kind": "mine"}).controller.kind == "mine"


def test_a_law_that_fails_in_a_run_is_told_by_its_line():
    with pytest.warns(UserWarning, match="plain Python"):
        fl.register(fl.Law("mine", raises, State, Gains), Mine)
    high = BENCH.evolve({"controller.kind": "mine", "setpoint": fl.Constant(offset_n=0.5)})
    fl.simulate(high, 0.002)
    higher = fl.Steps(times_s=(0.0, 0.005), levels_n=(0.5, 20.0))
    raised = high.evolve({"setpoint": higher, "sensor.range_n": 30.0})
    for run in (lambda: fl.simulate(raised, 0.01), lambda: fl.sweep(raised, KPS, 0.01)):
        with pytest.raises(fl.FrictionloopError, match=HERE + "ValueError: too high") as refused:
            run()
        assert 'law "mine": ' in str(refused.value)


def test_a_law_that_computes_no_number_is_told():
    @fl.step
    def lost(state, measured, setpoint_n, gains, dt):
        return state, fl.ForceCommand(0.0 * state.integral / 0.0, 0.0)

    fl.register(fl.Law("mine", lost, State, Gains), Mine)
    system = BENCH.evolve({"controller.kind": "mine"})
    with pytest.raises(fl.FrictionloopError, match=r'law "mine": .* at 0 s'):
        fl.simulate(system, 0.002)
    with pytest.raises(fl.FrictionloopError, match=r"law \"mine\": .*{'controller.kp': 0.05}"):
        fl.sweep(system, KPS, 0.002)


def test_what_the_compiler_does_not_know_is_told_by_its_line():
    table = {"a": 1.0}

    @fl.step
    def looks_up(state, measured, setpoint_n, gains, dt):
        return state, fl.ForceCommand(table["a"], 0.0)

    fl.register(fl.Law("mine", looks_up, State, Gains), Mine)
    with pytest.raises(fl.FrictionloopError, match="law-mine.*" + HERE + ".*table.*dict") as refused:
        fl.simulate(BENCH.evolve({"controller.kind": "mine"}), 0.002)
    assert "\n" not in str(refused.value)
    with pytest.raises(fl.FrictionloopError, match="mine: .*" + HERE + ".*table.*dict") as refused:
        fl.design.check(BENCH.evolve({"controller.kind": "mine"}))
    assert "\n" not in str(refused.value)


def test_a_law_that_has_no_c_is_refused_for_a_board_by_function_line_and_text():
    @fl.step
    def decays(state, measured, setpoint_n, gains, dt):
        return state, fl.ForceCommand(setpoint_n * math.exp(-dt), 0.0)

    fl.register(fl.Law("mine", decays, State, Gains), Mine)
    with pytest.raises(fl.FrictionloopError, match=r"^decays, line \d+: .*math\.exp\(-dt\)") as refused:
        fl.firmware.build(BENCH.evolve({"controller.kind": "mine"}), "none", "mps2")
    assert refused.value.code == "NO-C"


def friction(step, coefficients_of=lambda f: Share(1.0), **more):
    fl.register(fl.Vibration("own", step, Share, coefficients_of, **more), OwnFriction)


class OwnFriction(fl.FingerFriction):
    kind: Literal["own"] = "own"


class Share(NamedTuple):
    per_um: float


def falls(amplitude_um, occluded, coefficients):
    return 2.0 ** (-amplitude_um * coefficients.per_um)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"step": falls}, HERE + "step .*@fl.step"),
        ({"step": fl.step(lambda a, o, c: 2.0 ** (-a * c.per_mm))}, HERE + "AttributeError: .*'per_mm'"),
        ({"step": fl.step(lambda a, o, c: 1.0 + a)}, HERE + "step .*1 at 0 um, 1.5 at 0.5 um"),
        ({"step": fl.step(lambda a, o, c: 0.5 - a)}, HERE + "step .*0.5 at 0 um, 0 at 0.5 um"),
        ({"step": fl.step(lambda a, o, c: None)}, HERE + "step .*number"),
        ({"step": fl.step(falls), "coefficients_of": lambda f: (1.0, 2.0)}, HERE + "coefficients_of "),
        ({"step": fl.step(falls), "inverse": falls}, HERE + "inverse .*@fl.step"),
        ({"step": fl.step(lambda a, o, c: float("nan"))}, HERE + "step .*nan"),
        # Python stops at this root, compiled code gives no number.
        ({"step": fl.step(lambda a, o, c: 1.0 - a + math.sqrt(1.0 - a))}, HERE + "step .*nan"),
        ({"step": fl.step(lambda a, o, c: 2.0**-a - 0.2 * o * a)}, HERE + "step .*-0.3.* at 2.5 um"),
    ],
)
def test_a_friction_law_that_cannot_run_is_refused(given, told):
    with pytest.raises(fl.FrictionloopError, match='friction law "own": ' + f"(?s:.*){told}"):
        friction(**given)


class Failing(NamedTuple):
    until_um: float
    below: float


class FailingFriction(fl.FingerFriction):
    kind: Literal["failing"] = "failing"
    until_um: float = 3.0
    below: float = 0.0


@fl.step
def fails(amplitude_um, occluded, coefficients):
    """A law that is no number beyond an amplitude, or less than none there: one for both compiles half as long."""
    if coefficients.below > 0.0:
        return 1.0 - 0.3 * amplitude_um if amplitude_um <= coefficients.until_um else -0.1
    return 1.0 - 0.3 * amplitude_um + math.sqrt(coefficients.until_um - amplitude_um) * 0.0


FAILS = fl.Vibration("failing", fails, Failing, lambda f: Failing(f.until_um, f.below))
"""One block for all tests, whose tiles are compiled once."""


@pytest.mark.parametrize(("below", "told"), [(0.0, "nan at 1.1"), (1.0, "-0.1 at 1.1")])
@pytest.mark.parametrize("contact", ["bristle", pytest.param("rigid", marks=pytest.mark.slow)])
def test_friction_that_is_no_number_or_less_than_none_is_an_error_of_the_run(below, told, contact):
    fl.register(FAILS, FailingFriction)
    finger = {"finger.kind": "rigid"} if contact == "rigid" else {}
    system = BENCH.evolve({"friction.kind": "failing", "setpoint": fl.Constant(offset_n=0.3)})
    system = system.evolve(finger)
    short = 0.02
    fl.simulate(system, short)
    wrong = system.evolve({"friction.until_um": 1.1, "friction.below": below})
    told = rf'friction law "failing": {HERE}.*{told}\d* um .*0 to 1'
    with pytest.raises(fl.FrictionloopError, match=told) as refused:
        fl.simulate(wrong, short)
    assert "\n" not in str(refused.value)
    with pytest.raises(fl.FrictionloopError, match=told.replace("um .*", "um .*with {'controller.kp': 0.05}.*")):
        fl.sweep(wrong, KPS, short)
    loop = fl.Stepper(wrong)
    with pytest.raises(fl.FrictionloopError, match=told):
        for _ in range(100):
            loop.tick(2.0)


class Sig(fl.Signal):
    kind: Literal["own"] = "own"

    def force_n(self, time_s):
        return FORCES[self.kind](time_s)


FORCES: dict[str, Any] = {}


@pytest.mark.parametrize(
    ("force", "told"),
    [
        (lambda t: t[:-1], r"force_n .*\(2,\).*\(3,\)"),
        (lambda t: 0.5, r"force_n .*\(\).*\(3,\)"),
        (lambda t: np.where(t > 1e-4, np.nan, 0.5), "force_n .*nan at 0.0002 s"),
        (lambda t: t.nothing, "AttributeError: .*nothing"),
        (lambda t: "high", "ValueError: could not convert string to float: 'high'"),
    ],
)
def test_a_signal_that_says_no_force_is_refused(monkeypatch, force, told):
    monkeypatch.setitem(FORCES, "own", force)
    with pytest.raises(fl.FrictionloopError, match='signal "own": ' + HERE + told):
        fl.register(Sig)


def test_a_signal_that_fails_later_is_told_when_it_does(monkeypatch):
    monkeypatch.setitem(FORCES, "own", lambda t: np.where(t > 0.01, np.nan, 0.5))
    fl.register(Sig)
    late = BENCH.evolve({"setpoint.kind": "own"})
    with pytest.raises(fl.FrictionloopError, match=r'signal "own": .*nan at 0.0102 s'):
        fl.simulate(late, 0.02)
    with pytest.raises(fl.FrictionloopError, match=r'setpoint.kind = "own": .*force_n'):
        fl.linearise(late)


def test_a_signal_without_a_function_is_refused():
    class Silent(fl.Signal):
        kind: Literal["silent"] = "silent"

    with pytest.raises(fl.FrictionloopError, match=r'signal "silent": Silent .*force_n\(self, time_s\)'):
        fl.register(Silent)


class Most(NamedTuple):
    most: float


def most(state, sample, dt):
    return Most(max(state.most, sample.u))


@pytest.mark.parametrize(
    ("metric", "told"),
    [
        (fl.StreamingMetric("own", most, Most, nothing), HERE + "step .*@fl.step"),
        (fl.StreamingMetric("own", fl.step(lambda s, x, dt: Most(x.uu)), Most, nothing), HERE + "AttributeError: .*uu"),
        (fl.StreamingMetric("own", fl.step(lambda s, x, dt: x.u), Most, nothing), HERE + "step .*0.6"),
        (fl.StreamingMetric("own", fl.step(most), float, nothing), "state = .*NamedTuple"),
        (fl.RunMetric("own", 3.0), "of = 3: "),
        (fl.RunMetric("rms_error", nothing), "metric 'rms_error': taken; choose another name"),
        (fl.RunMetric("own one", nothing), 'metric "own one": '),
    ],
)
def test_a_metric_that_cannot_run_is_refused(metric, told):
    with pytest.raises(fl.FrictionloopError, match=told):
        fl.register(metric)


@pytest.mark.parametrize(
    ("of", "told"),
    [
        (lambda state, count: np.zeros(7), HERE + "ValueError: .*shape"),
        (lambda state, count: state.least, HERE + "AttributeError: .*'least'"),
    ],
)
def test_a_metric_whose_value_fails_is_told_by_its_line(of, told):
    fl.register(fl.StreamingMetric("own", fl.step(most), Most, of))
    with pytest.raises(fl.FrictionloopError, match='metric "own": ' + told):
        fl.sweep(BENCH, KPS, 0.002, metrics=["own"])


@pytest.mark.parametrize(
    ("of", "told"), [(lambda run: run.f_a.values, r".*\(10,\)"), (lambda run: run.nothing, "AttributeError: .*nothing")]
)
def test_a_metric_of_runs_that_fails_is_told_by_its_line(of, told):
    fl.register(fl.RunMetric("own", of))
    with pytest.raises(fl.FrictionloopError, match='metric "own": ' + HERE + told):
        fl.sweep(BENCH, KPS, 0.002, metrics=["own"])
