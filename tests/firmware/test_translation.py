"""Steps as C: the same bits as Numba's, for each law and for steps drawn at random; what has no C is refused."""

from __future__ import annotations

import ctypes
import re
import subprocess
from typing import Literal, NamedTuple

import numpy as np
import pytest
from numba import njit

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.firmware.c_types import BOOL, INT, REAL
from frictionloop.firmware.host_compiler import compiler, shared_library, zig
from frictionloop.firmware.translation import INCLUDES, Translation
from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.scalar_math import exp2, fma, log2
from frictionloop.quantities.scalar_math import step as compiled
from frictionloop.sensing.finger_tracking import TouchState, touch_coefficients, touch_step
from frictionloop.sensing.measurement import Measurement
from tests.helpers.random_steps import module_of

STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
SPECIAL = [0.0, -0.0, 1.0, -1.0, 0.5, 1e-310, 5e-324, 1e300, -1e300, np.inf, -np.inf, np.nan]


def built(tmp_path, source, flags=STRICT):
    path = tmp_path / "translated.c"
    path.write_text(INCLUDES + "#include <string.h>\n" + source, encoding="utf-8")
    return ctypes.CDLL(str(shared_library("translated", [path], flags=flags)))


def address(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def same_bits(a, b):
    """Tell whether doubles are the same bit for bit; one NaN is like another."""
    return np.array_equal(a[~np.isnan(a)].view(np.int64), b[~np.isnan(b)].view(np.int64)) and np.array_equal(
        np.isnan(a), np.isnan(b)
    )


def readings(count, seed=0):
    """Return measurements and set-points of strokes with jumps and lifts."""
    draw, t = np.random.default_rng(seed), np.arange(count) * 2e-4
    stroke = 2 * np.pi * t
    force = 0.5 + 0.15 * np.sin(3 * stroke) + 0.05 * draw.normal(size=count) + 0.3 * (draw.random(count) < 1e-3)
    speed = 0.04 * np.cos(stroke)
    valid = (np.abs(speed) > 0.004) & (draw.random(count) > 1e-3)
    measured = np.stack([force, 0.02 * np.sin(stroke), speed, 0.5 + 0.05 * draw.normal(size=count), valid], axis=1)
    return np.ascontiguousarray(measured), 0.58 + 0.18 * np.sin((1 + 0.5 * t) * stroke)


@pytest.mark.parametrize("kind", LAWS)
def test_a_law_gives_the_same_bits_in_c(tmp_path, kind):
    law, controller = LAWS[kind], fl.bench().evolve({"controller.kind": kind}).controller
    within = Translation()
    state, gains, measurement = (within.struct(shape) for shape in (law.state, law.gains, Measurement))
    name, result = within.function(law.step, [state, measurement, REAL, gains, REAL])
    library = built(
        tmp_path,
        within.text()
        + f"""
void run({state} *state, const {measurement} *m, const double *f_r, const {gains} *gains, double *out, int n) {{
    for (int i = 0; i < n; i++) {{
        {result} r = {name}(*state, m[i], f_r[i], *gains, 2e-4);
        *state = r.of0;
        out[2 * i] = r.of1.u;
        out[2 * i + 1] = r.of1.saturated;
    }}
}}
""",
    )
    count = 50_000
    m, f_r = readings(count)
    start = np.array(flat_tuples.flat(law.start_for(controller)), float)
    values = np.array(flat_tuples.flat(law.gains_for(controller)), float)
    step = law.step

    @njit(error_model="numpy")
    def run(state, gains, m, f_r, out):
        for k in range(f_r.size):
            measured = Measurement(m[k, 0], m[k, 1], m[k, 2], m[k, 3], m[k, 4])
            state, command = step(state, measured, f_r[k], gains, 2e-4)
            out[k, 0], out[k, 1] = command[0], command[1]
        return state

    ours, theirs, ended = np.empty((count, 2)), np.empty((count, 2)), start.copy()
    last = run(
        flat_tuples.shaped(law.state, start.tolist()), flat_tuples.shaped(law.gains, values.tolist()), m, f_r, ours
    )
    library.run(address(ended), address(m), address(f_r), address(values), address(theirs), count)
    assert same_bits(ours, theirs) and same_bits(np.array(flat_tuples.flat(last), float), ended)
    assert np.ptp(ours[:, 0]) > 0.05


def test_touch_gives_the_same_bits_in_c(tmp_path):
    coefficients = touch_coefficients(fl.bench().touch, 2e-4)
    within = Translation()
    state, shape = within.struct(TouchState), within.struct(type(coefficients))
    name, result = within.function(touch_step, [state, REAL, REAL, REAL, REAL, shape])
    library = built(
        tmp_path,
        within.text()
        + f"""
void run({state} *state, const double *x, const double *load, const {shape} *c, double *out, int n) {{
    for (int i = 0; i < n; i++) {{
        {result} r = {name}(*state, x[i], load[i], 0.5, -0.25, *c);
        *state = r.of0;
        memcpy(out + 4 * i, &r.of1, 32);
    }}
}}
""",
    )
    count, start = 20_000, np.array([0.0] * 5 + [1.0, 0.0])
    t = np.arange(count) * 2e-4
    x, load = 0.02 * np.sin(2 * np.pi * 2 * t), 0.5 * (np.sin(2 * np.pi * 0.7 * t) > -0.8)

    @njit(error_model="numpy")
    def run(state, x, load, c, out):
        for k in range(x.size):
            state, told = touch_step(state, x[k], load[k], 0.5, -0.25, c)
            out[k, 0], out[k, 1], out[k, 2], out[k, 3] = told
        return state

    ours, theirs = np.empty((count, 4)), np.empty((count, 4))
    run(flat_tuples.shaped(TouchState, start.tolist()), x, load, coefficients, ours)
    library.run(
        address(start), address(x), address(load), address(np.array(coefficients, float)), address(theirs), count
    )
    assert same_bits(ours, theirs)
    assert 0.2 < ours[:, 3].mean() < 0.9


@pytest.mark.parametrize("count", [8, pytest.param(60, marks=pytest.mark.slow)])
def test_steps_drawn_at_random_give_the_same_bits_in_c(tmp_path, count):
    """Steps of all that is accepted, 20,000 evaluations each: of sixty no bit differs in a million."""
    steps, seed = module_of(tmp_path, count, count), count
    within = Translation()
    entries = []
    for k, function in enumerate(steps.STEPS):
        name, kind = within.function(function, [within.struct(steps.State), REAL, REAL, INT, BOOL])
        entries.append(
            f"void run{k}(const double *in, double *out, int n) {{\n"
            f"    for (int i = 0; i < n; i++, in += 6) {{\n"
            f"        {kind} r = {name}((State){{in[0], in[1]}}, in[2], in[3], (int64_t)in[4], in[5] != 0.0);\n"
            f"        out[3 * i] = r.of0.a; out[3 * i + 1] = r.of0.b; out[3 * i + 2] = r.of1;\n    }}\n}}\n"
        )
    library = built(tmp_path, within.text() + "\n".join(entries), ("-std=c99", "-O2", "-ffp-contract=off", "-w"))
    count, draw = 20_000, np.random.default_rng(seed)
    given = draw.normal(size=(count, 6)) * 10.0 ** draw.integers(-3, 4, size=(count, 1))
    odd = draw.random((count, 4)) < 0.02
    given[:, :4] = np.where(odd, draw.choice(SPECIAL, size=(count, 4)), given[:, :4])
    given[:, 4], given[:, 5] = draw.integers(-1000, 1000, size=count), draw.random(count) < 0.5
    differ, moved = [], []
    for k, function in enumerate(steps.STEPS):

        @njit(error_model="numpy")
        def run(given, out, function=function, State=steps.State):
            for i in range(given.shape[0]):
                row = given[i]
                state, y = function(State(row[0], row[1]), row[2], row[3], int(row[4]), row[5] != 0.0)
                out[i, 0], out[i, 1], out[i, 2] = state.a, state.b, y

        ours, theirs = np.empty((count, 3)), np.empty((count, 3))
        run(given, ours)
        getattr(library, f"run{k}")(address(given), address(theirs), count)
        moved.append(np.unique(ours[np.isfinite(ours)]).size)
        if not same_bits(ours, theirs):
            differ.append(function.__name__)
    assert differ == []
    assert np.median(moved) > 1000


class Pair(NamedTuple):
    a: float
    b: float


@compiled
def dear_step(x: float) -> tuple[float, float]:
    return exp2(x), log2(x)


@compiled
def uses_it(x: float) -> float:
    a, b = dear_step(x)
    a, b = b, a
    return a - b


def test_a_call_that_returns_a_tuple_is_evaluated_once():
    within = Translation()
    within.function(uses_it, [REAL])
    assert len(re.findall(r"dear_step\(", within.text())) == 2  # where it is and where it is called
    assert len(re.findall(r"part\d = [ab];", within.text())) == 2  # swapped, none overwritten before


def refuses_list(x: float) -> float:
    y = [x, x]
    return y[0]


def refuses_exp(x: float) -> float:
    return np.exp(x)


def refuses_power(x: float) -> float:
    return x**3


def refuses_or(x: float) -> float:
    return x or 1.0


def refuses_no_value(x: float) -> float:  # type: ignore[return]
    if x > 0.0:
        return x


def refuses_kinds(x: float) -> float:
    y = 0
    if x > 0.0:
        y = 0.5
    return y + x


def refuses_while(x: float) -> float:
    while x > 1.0:
        x = x / 2.0
    return x


def refuses_itself(x: float) -> float:
    return refuses_itself(x)


def refuses_words(x: float) -> float:
    return 1.0 if np.uint64(x) < 1 else 0.0


def refuses_shift(x: float) -> float:
    return float(int(x) << -1)


REFUSED = {
    refuses_list: "no C: [x, x]",
    refuses_exp: "calls what has no C: np.exp(x)",
    refuses_power: "no power but the square of a variable: x ** 3",
    refuses_or: "and, or of numbers: x or 1.0",
    refuses_no_value: "may end without a value: if x > 0.0:",
    refuses_kinds: "int64_t before and double here: y",
    refuses_while: "no C: while x > 1.0:",
    refuses_itself: "calls itself",
    refuses_words: "no C: np.uint64(x) < 1",
    refuses_shift: "no shift but of an int by 0 to 63: int(x) << -1",
}


@pytest.mark.parametrize("function", REFUSED, ids=lambda each: each.__name__)
def test_what_has_no_c_is_refused_by_function_line_and_text(function):
    with pytest.raises(fl.FrictionloopError) as refused:
        Translation().function(function, [REAL])
    assert refused.value.code == "NO-C"
    first = function.__code__.co_firstlineno
    found = re.fullmatch(rf"{function.__name__}(?:, line (\d+))?: (.*)", str(refused.value))
    assert found[2] == REFUSED[function]
    assert found[1] is None or first < int(found[1]) <= first + 3


def test_names_of_c_are_no_trouble(tmp_path):
    def register(double: float, log2: float) -> float:
        int = double * log2
        return fma(int, double, 1.0)

    within = Translation()
    name, _ = within.function(register, [REAL, REAL])
    library = built(tmp_path, within.text() + f"double call(double x) {{ return {name}(x, 3.0); }}\n")
    library.call.restype, library.call.argtypes = ctypes.c_double, [ctypes.c_double]
    assert library.call(2.0) == 13.0


TABLE = {"controller.model.table_size": 129}


@pytest.mark.parametrize(
    ("kind", "more"), [("pi", {}), ("pi", TABLE), ("notch_pi", {"controller.overdrive": True}), ("limit_observer", {})]
)
@pytest.mark.parametrize("command", [compiler, zig], ids=["cc", "zig"])
def test_a_law_as_a_file_of_c_prints_the_digest_of_the_simulator(tmp_path, kind, more, command):
    system = fl.bench().evolve({"controller.kind": kind, **more})
    found = fl.firmware.law(system, tmp_path / "law.c")
    built = [*command(), *STRICT, "-DBIT_TEST", "law.c", "-o", "law", "-lm"]
    subprocess.run(built, cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "law"], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == found.digest
    other = fl.firmware.law(system.evolve({"controller.model.nominal_n": 1.01}), tmp_path / "other.c")
    assert other.digest != found.digest


def test_a_law_that_rings_says_so(tmp_path):
    codes = [
        [each.code for each in fl.firmware.law(fl.bench().evolve(gains), tmp_path / "law.c").findings]
        for gains in ({"controller.kp": 10.0}, fl.RETUNED)
    ]
    assert codes == [["LOOP-UNSTABLE"], []]


def test_a_law_of_ones_own_comes_along(tmp_path):
    @compiled
    def half_step(state, measured, setpoint_n, gains, dt):
        u = min(max(gains.share * setpoint_n, gains.low), gains.high)
        return state, fl.ForceCommand(u, 0.0 if u == gains.share * setpoint_n else 1.0)

    class Half(fl.Timing):
        kind: Literal["half"] = "half"
        share: float = 0.5

    class Gains(NamedTuple):
        share: float
        low: float
        high: float

    fl.register(fl.Law("half", half_step, Pair, Gains), Half)
    try:
        found = fl.firmware.law(fl.bench().evolve({"controller.kind": "half"}), tmp_path / "law.c")
        assert "half_step" in (tmp_path / "law.c").read_text()
        subprocess.run([*compiler(), *STRICT, "-DBIT_TEST", "law.c", "-o", "law", "-lm"], cwd=tmp_path, check=True)
        printed = subprocess.run([tmp_path / "law"], capture_output=True, text=True, check=True).stdout
        assert printed.strip() == found.digest
    finally:
        forget()
