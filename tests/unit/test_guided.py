"""The loop under a finger that somebody moves is the loop of ``simulate``, and goes on when a number changes."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.live_loop import MOST, Guided

CALM = {"motion.tremor_um": 0.0, "controller.kind": "limit_observer"}
BENCH = fl.bench().evolve({"setpoint": {"kind": "effect"}, **CALM})


def path_of(run):
    """Return the path of a run's finger: where it is at the end of each period."""
    return np.stack([run[name].values for name in ("position", "speed", "load")], axis=1)[1:]


def stroke(start_m, periods, speed_m_s=0.04, load_n=0.5):
    path = np.empty((periods, 3))
    path[:, 0] = start_m + speed_m_s * 2e-4 * np.arange(1, periods + 1)
    path[:, 1:] = speed_m_s, load_n
    return path


def test_the_path_of_a_run_gives_the_run_bit_for_bit():
    run = fl.simulate(BENCH, 0.2, seed=3)
    loop, path = Guided(BENCH, seed=3), path_of(run)
    parts = [loop.advance(part) for part in np.split(path, [25, 26, 90, 500])]
    told = dict(zip(loop.names, np.concatenate(parts, axis=1), strict=True))
    for name in ("f_r", "f_a", "f_m", "u", "a", "position", "limit"):
        np.testing.assert_array_equal(told[name], run[name].values[:-1], err_msg=name)


def test_a_number_changes_without_a_jump_of_the_plate_and_takes_effect():
    loop, same = Guided(BENCH), Guided(BENCH)
    loop.advance(stroke(-0.03, 1000))
    same.advance(stroke(-0.03, 1000))
    assert loop.change(BENCH.evolve({"friction.nominal_n": 1.3}))
    after, beside = (each.advance(stroke(-0.022, 200)) for each in (loop, same))
    a, limit = loop.names.index("a"), loop.names.index("limit")
    assert after[a, 0] == beside[a, 0]
    np.testing.assert_allclose(after[limit] / beside[limit], 1.3 / 0.95)


@pytest.mark.parametrize(
    ("values", "goes_on"),
    [
        ({"controller.model.nominal_n": 1.1}, True),
        ({"sensor.resonance_hz": 200.0}, True),
        ({"setpoint.effect": fl.rendering.LIBRARY["rough"]}, True),
        ({"controller.kind": "pi"}, False),
        ({"controller.rate_hz": 4000.0}, False),
    ],
)
def test_what_makes_another_loop_begins_anew_at_rest(values, goes_on):
    loop = Guided(BENCH)
    loop.advance(stroke(-0.03, 300))
    assert loop.change(BENCH.evolve(values)) is goes_on
    assert (loop.period == 300) is goes_on
    assert np.isfinite(loop.advance(stroke(-0.0276, 300))).all()


def test_a_changed_model_gives_its_own_commands_at_the_clamp():
    """The commands at the ends of the clamp are prepared in period 0; a change has to prepare them again."""
    nothing = {"setpoint.effect": fl.rendering.Constant(level_n=0.0), "friction.nominal_n": 1.3}
    wide = BENCH.evolve({"controller.kind": "pi", "controller.model.table_size": 0, **nothing, **fl.RETUNED})
    wide, changed = wide.evolve({"controller.model.max_amplitude_um": 2.0}), wide
    loop = Guided(wide)
    loop.advance(stroke(-0.03, 200))
    assert loop.change(changed)
    told = dict(zip(loop.names, loop.advance(stroke(-0.0284, 2000)), strict=True))
    assert told["saturated"][-1]
    assert told["a"][-1] == pytest.approx(2.5, rel=1e-3)


def test_several_fingers_under_one_path_are_each_as_if_alone_bit_for_bit():
    people = [BENCH.evolve(finger) for finger in fl.fingers(3, seed=0)]
    changed = [each.evolve({"controller.model.nominal_n": 1.1}) for each in people]
    together, alone = Guided(people, seed=3), [Guided(each, seed=3) for each in people]
    for number, path in enumerate((stroke(-0.03, 300), stroke(-0.0276, 200))):
        if number:
            assert together.change(changed)
            assert all(loop.change(each) for loop, each in zip(alone, changed, strict=True))
        told = together.advance(path)
        for lane, loop in enumerate(alone):
            np.testing.assert_array_equal(told[..., lane], loop.advance(path))


def test_what_does_not_run_together_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r"^systems: "):
        Guided([BENCH, BENCH.evolve({"controller.kind": "pi"})])
    with pytest.raises(fl.FrictionloopError, match=r"^systems: 33;"):
        Guided([BENCH] * 33)


def test_what_cannot_be_moved_is_refused():
    with pytest.raises(fl.FrictionloopError, match=r'motion.kind = "sliding"'):
        Guided(fl.paper())
    loop = Guided(BENCH)
    with pytest.raises(fl.FrictionloopError, match=r'motion.kind = "sliding"'):
        loop.change(fl.paper())
    assert loop.system == BENCH
    with pytest.raises(fl.FrictionloopError, match="path"):
        loop.advance(np.zeros((MOST + 1, 3)))
