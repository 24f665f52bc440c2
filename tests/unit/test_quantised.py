"""Numbers of the firmware: what they stand for, that they fit the schema, and what is refused, in one line."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.firmware.compiled_core import controller_words, quantised_gains, quantised_start
from frictionloop.firmware.quantised import to_gain, to_q28
from frictionloop.firmware.quantised_filtered import places_for, section_sizes
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import parameter_words

BENCH = fl.bench()
NOTCH = fl.NotchPiController(feedforward=True, overdrive=True, model=BENCH.controller.model)


@given(st.floats(-(2.0**31), 2.0**31, exclude_min=True, exclude_max=True))
def test_a_gain_keeps_thirty_bits(value):
    if abs(value) > 2.0**31 * (1 - 2.0**-30):
        return  # rounds up to 2^31
    gain = to_gain(value)
    assert abs(gain.mantissa) <= 2**30
    assert -1 <= gain.shift <= 62
    assert math.ldexp(gain.mantissa, -gain.shift) == pytest.approx(value, rel=2.0**-30, abs=2.0**-63)


@given(st.floats(-8, 8 - 2.0**-28))
def test_q28_is_the_nearest(value):
    assert abs(to_q28(value, "force") * 2.0**-28 - value) <= 2.0**-29


@pytest.mark.parametrize(
    "system", [fl.paper(), fl.feasible(), BENCH, BENCH.evolve(fl.RETUNED), BENCH.evolve({"controller": NOTCH})]
)
def test_words_are_within_the_ranges_of_the_schema(system):
    for name, values in controller_words(system).items():
        word = parameter_words()[name]
        assert values.dtype == np.int32
        assert len(values) == word.words
        bounded = values[1::2] if word.format == "gain" else values / 2.0 ** {"q28": 28, "q25": 25}.get(word.format, 0)
        assert word.low is None or np.min(bounded) >= word.low
        assert word.high is None or np.max(bounded) <= word.high


def test_words_say_what_the_model_believes():
    words, model = controller_words(BENCH), BENCH.controller.model
    assert words["law.number"] == [1]
    mantissas, shifts = words["law.gains"][:4:2], words["law.gains"][1:4:2]
    np.testing.assert_allclose(mantissas * 2.0**-shifts, [10.0, 2.0 / 5000.0], rtol=2.0**-30)
    squares = words["lookup.squares_um2"] / 2.0**25
    forces = np.linspace(model.floor_n, model.nominal_n, 257)
    friction = model.nominal_n * np.exp(-model.susceptibility_per_um2 * squares)
    np.testing.assert_allclose(friction, forces, atol=model.susceptibility_per_um2 * 2.0**-25)
    assert words["overdrive.decay"] == [0]
    own = BENCH.evolve({"friction.susceptibility_per_um2": 0.5, "friction.nominal_n": 1.3})
    assert all(np.array_equal(values, words[name]) for name, values in controller_words(own).items())


def test_feed_forward_starts_at_the_believed_friction():
    start = quantised_start(NOTCH)
    assert start[:13] == [0] * 13
    f0 = NOTCH.model.nominal_n
    assert start[13:18] == [round(f0 * 2.0**28)] * 5
    assert start[18] == start[20] == pytest.approx(f0 * 2.0 ** places_for(8 * (4 * 20 / math.pi + 2)), abs=1)


@given(
    st.lists(
        st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)),
        min_size=1, max_size=4,
    ),
    st.integers(0, 2**32),
)  # fmt: skip
def test_free_sections_stay_within_their_bounds(roots, seed):
    sections = [(1.0, -(a + b), a * b, -(c + d), c * d) for a, b, c, d in roots]
    sizes = section_sizes(sections, 1.0, False)
    x = np.random.default_rng(seed).choice([-8.0, 8.0], 200)
    for (b0, b1, b2, a1, a2), size in zip(sections, sizes.sections, strict=True):
        y, s1, s2 = np.empty_like(x), 0.0, 0.0
        for k in range(len(x)):
            y[k] = b0 * x[k] + s1
            s1, s2 = b1 * x[k] - a1 * y[k] + s2, b2 * x[k] - a2 * y[k]
            assert max(abs(y[k]), abs(s1), abs(s2), abs(b1 * x[k]), abs(a1 * y[k])) <= size * 1.02
        x = y


WILD = (0.5, 0.5, 0.5, -1.999, 0.9999)
REFUSED = {
    "a large ki": (fl.PiController(ki=5000.0), r"^controller\.ki = 5000 1/s: must be at most 4500"),
    "sections that resonate": (
        fl.FilteredPiController(sections=(WILD,) * 3, kp=1.0, ki=1.0),
        r"^controller\.sections: step = .* N: must be at most 1e-05",
    ),
    "a long memory": (
        fl.FilteredPiController(sections=((1.0, 0.0, 0.0, -1.0 + 1e-9, 0.0),)),
        r"^controller\.sections: radius = .*: must be forgotten in 1048576 periods",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_does_not_fit_is_refused_in_one_line(name):
    controller, pattern = REFUSED[name]
    with pytest.raises(FrictionloopError, match=pattern) as refusal:
        quantised_gains(controller)
    assert "\n" not in str(refusal.value)
