"""For how many people a set-point can be rendered, and how well: against sweeps, `capable` and closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design import people_served
from frictionloop.design.people_reach import people_reach, share_of_all
from frictionloop.findings import Finding

N, SEED = 12, 5
SYSTEM = fl.bench().evolve(fl.RETUNED)
OPTIONS = {"count": N, "seed": SEED, "duration_s": 0.5, "score_from_s": 0.2}


def swept(system=SYSTEM, metrics=people_served.METRICS):
    return fl.sweep(system, fl.fingers(N, SEED), 0.5, metrics=metrics, score_from_s=0.2)


@pytest.fixture(scope="module")
def found():
    return fl.people(SYSTEM, **OPTIONS)


def codes(found):
    return {each.code for each in found.findings}


def test_metrics_are_those_of_a_sweep_and_fingers_those_of_capable(found):
    result = swept()
    assert list(found.grid) == [*people_served.METRICS[:2], "open_loop_rms_error", *people_served.METRICS[2:]]
    for name in people_served.METRICS:
        np.testing.assert_array_equal(found.grid[name], result[name])
        assert found.spread(name)["median"] == np.median(result[name])
    rms, r2 = sorted(result.rms_error.values[:, 0]), sorted(result.r2_identity.values[:, 0])
    assert found.spread("rms_error") == {"median": np.median(rms), "worst_decile": rms[10], "fingers": N}
    assert found.spread("r2_identity")["worst_decile"] == r2[1]  # 11 of 12 are as good or better
    able = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5)
    moving = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5, load_moves=True).capable.values
    assert 0 < moving.sum() < able.capable.sum() < N
    np.testing.assert_array_equal(found.grid.capable, able.capable)
    np.testing.assert_array_equal(found.grid.lowest_n, able.lowest_n)
    np.testing.assert_array_equal(found.grid.served, moving)
    assert (found.reach.low_n, found.reach.high_n) == pytest.approx((0.5, 0.7))
    assert (found.served, found.complete) == (moving.sum(), True)
    some = result.rms_error.values[moving, 0]
    assert found.spread("rms_error", moving)["median"] == np.median(some)
    assert found.table("able").loc["1 x 0.5 s on the plate"].tolist() == [able.capable.sum(), moving.sum()]
    parts = found.by_coefficient()
    assert (parts["people"].sum(), parts["served"].sum()) == (N, found.served)
    assert "PEOPLE-UNLIKE" not in codes(found) and "OWN-RINGS" not in codes(found)


def test_the_error_in_open_loop_is_that_of_the_lookup_table_alone(found):
    opened = fl.bench().evolve({"controller.kind": "lookup"})
    np.testing.assert_array_equal(found.grid.open_loop_rms_error, swept(opened, ["rms_error"]).rms_error)
    for more in ({"system": opened}, {"metrics": ["r2_identity"]}):
        assert "open_loop_rms_error" not in fl.people(**{"system": SYSTEM} | OPTIONS | more).grid


def test_its_figure_draws_both_errors_in_one_panel(found):
    panels = found.plot().axes
    assert [panel.get_ylabel() for panel in panels] == [
        "r2_identity", "rms_error (mN)", "saturation_index", "perceptual_index",
    ]  # fmt: skip
    assert panels[1].get_legend().get_texts()[0].get_text().startswith("open loop, median ")


def test_coefficients_and_loads_are_as_asked():
    drawn = fl.fingers(200, 1, loads_n=(0.4, 1.2), coefficients=(0.3, 0.9))
    loads, mu = [each["motion.load_n"] for each in drawn], [fl.coefficient_of(each) for each in drawn]
    assert 0.4 <= min(loads) < 0.45 and 1.15 < max(loads) <= 1.2
    assert 0.3 <= min(mu) < 0.33 and 0.87 < max(mu) <= 0.9
    one = SYSTEM.evolve(drawn[0] | {"motion.speed_mm_s": 20.0})
    from frictionloop.analysis.operating_point import law_at

    assert law_at(one).nominal_n / one.motion.load_n == pytest.approx(mu[0])
    with pytest.raises(fl.FrictionloopError, match="coefficients"):
        fl.fingers(3, 0, coefficients=(0.9, 0.3))


def test_fingers_unlike_that_of_the_system_come_first():
    light = fl.people(SYSTEM, 4, duration_s=0.1, coefficients=(0.2, 0.4))
    assert light.findings[0].code == "PEOPLE-UNLIKE"
    assert light.findings[0].value == SYSTEM.friction.nominal_n > light.findings[0].more["high"]
    assert set(light.grid.coefficient.values) == {fl.coefficient_of(each) for each in light.people}


def test_a_loop_that_rings_is_told():
    rings = fl.people(fl.bench(), 2, duration_s=0.1)
    (told,) = (each for each in rings.findings if each.code == "OWN-RINGS")
    assert math.isinf(told.value)


def test_what_each_finger_replaces(found):
    assert set(found.replaced) == set(fl.fingers(1, 0)[0]) - {"motion.person"}
    assert found.replaced["motion.load_n"] == SYSTEM.motion.load_n
    loads = [each["motion.load_n"] for each in fl.fingers(N, SEED)]
    row = found.table("in place of the file's").loc["motion.load_n"]
    assert (row["file"], row["least"], row["largest"]) == (0.5, min(loads), max(loads))


def test_fingers_of_a_measured_population(tmp_path):
    file = tmp_path / "people.toml"
    file.write_text('fingers = 4\n[[value]]\npath = "friction.nominal_n"\nmedian = 1.2\nspread = 0.0\n')
    assert {each["friction.nominal_n"] for each in fl.fingers_for(fl.bench(), 5, 0, file)} == {1.2}


def test_several_seeds_count_by_their_mean():
    found = fl.people(SYSTEM, 1, duration_s=0.2, seeds=2)
    assert found.spread("rms_error")["median"] == pytest.approx(found.grid.rms_error.values.mean())
    assert (found.runs_done, found.runs) == (2, 2)


def test_worst_decile_of_each_kind_of_metric(found):
    given = {
        "rms_error": ([0.1, 0.4, 0.2, 0.3], 0.4),
        "perceptual_index": ([3.0, 2.0, 1.0, np.nan], 3.0),
        "r2_identity": ([0.1, 0.4, 0.2, 0.3], 0.1),
        "slope": ([1.1, 0.8, 1.0, 1.15], 0.8),
        "rise_63_s": ([np.nan] * 4, np.nan),
    }
    four = replace(
        found,
        grid=found.grid.isel(finger=slice(4)).assign(
            {k: (("finger", "seed"), np.array(v)[:, None]) for k, (v, _) in given.items()}
        ),
    )
    for name, (values, worst) in given.items():
        spread = four.spread(name)
        assert spread["worst_decile"] == pytest.approx(worst, nan_ok=True)
        assert spread["fingers"] == np.sum(~np.isnan(values))


def test_the_finger_is_held_until_the_last_contact_of_the_run_ends():
    people = fl.fingers(30, 0)
    system = fl.bench().evolve({"motion.contact_s": 2.0, "motion.lifted_s": 0.5})
    band, reach = people_reach(system, people, 10.0)
    assert (reach.contact_s, reach.contacts) == (2.0, 4)
    np.testing.assert_array_equal(band.high_n, fl.capable(people, contact_s=2.0, contacts=4).highest_n)
    end = fl.capable(people, 0.5, 0.7, contact_s=2.0, contacts=np.inf).capable
    assert reach.in_the_end.sum() == end.sum() < sum(reach.able)
    once, stays = (people_reach(system.evolve({"motion.contact_s": each}), people, 10.0)[1] for each in (12.0, 0.0))
    for each in (once, stays):
        assert (each.contact_s, each.contacts) == (10.0, 1)
    # A run of a part of one contact: who lifts after it lands again, and is moister in the end.
    again = fl.capable(people, 0.5, 0.7, contact_s=12.0, contacts=np.inf)
    np.testing.assert_array_equal(once.in_the_end, again.capable)
    assert stays.in_the_end is None and 0 < again.capable.sum() < once.able.sum()
    assert once.able.tolist() == stays.able.tolist()
    _, weak = people_reach(system.evolve({"plate.max_amplitude_um": 1.0}), people, 10.0)
    assert weak.low.sum() < reach.low.sum()


def test_values_of_the_system_that_no_finger_brings_count():
    brought = "friction.occlusion_s"
    people = [{path: value for path, value in each.items() if path != brought} for each in fl.fingers(5, 0)]
    quick, plain = (
        people_reach(fl.bench().evolve({"friction.occlusion_s": each}), people, 1.0)[0] for each in (2.0, 20.0)
    )
    named = fl.capable([{"friction.occlusion_s": 2.0} | each for each in people], 0.5, 0.7, contact_s=1.0)
    assert quick.low_n.tolist() == named.lowest_n.values.tolist() != plain.low_n.tolist()


def test_drawn_friction_is_that_at_the_load_and_speed_of_the_drawing_whatever_the_files():
    people = fl.fingers(5, 0)
    other = fl.bench().evolve({"friction.reference_load_n": 0.25, "friction.reference_speed_mm_s": 60.0})
    there, plain = (people_reach(each, people, 1.0)[0] for each in (other, fl.bench()))
    assert there.high_n.tolist() == plain.high_n.tolist()
    errors = [fl.sweep(each, people, 1.0, metrics=["rms_error"]).rms_error.values for each in (other, fl.bench())]
    np.testing.assert_array_equal(*errors)


def test_a_set_point_from_outside_is_not_judged():
    class Hum(fl.Signal):
        """A force from outside."""

        kind: str = "hum"

        def force_n(self, time_s):
            """Return 0.5 N."""
            return 0.5 + 0.0 * time_s

    system = fl.bench().model_copy(update={"setpoint": Hum()})
    found = people_reach(system, fl.fingers(3, 0), 0.5)[1]
    assert isinstance(found, Finding) and found.code == "REACH-UNKNOWN"


@pytest.mark.parametrize(("able", "total"), [(0, 30), (9, 30), (42, 100), (100, 100)])
def test_what_a_draw_says_of_all_fingers_is_wilsons_interval(able, total):
    """(p + z^2/2n -+ z sqrt(p(1 - p)/n + z^2/4n^2))/(1 + z^2/n) with z of 97.5 %."""
    z, p = 1.959963984540054, able / total
    middle, half = p + z * z / (2 * total), z * math.sqrt(p * (1 - p) / total + (z / (2 * total)) ** 2)
    wanted = [(middle + sign * half) / (1 + z * z / total) for sign in (-1.0, 1.0)]
    assert share_of_all(able, total) == pytest.approx(wanted, abs=1e-9)


def test_ctrl_c_carries_what_was_found_and_keeps_it(monkeypatch, tmp_path):
    partial, path = swept(), tmp_path / "f.h5"
    for values in partial.data_vars.values():
        values[5:] = np.nan
    partial.attrs["runs_done"] = 5

    def stopped(*_, **__):
        raise fl.SweepInterrupted(partial)

    monkeypatch.setattr(people_served, "sweep", stopped)
    with pytest.raises(fl.PeopleInterrupted) as stop:
        fl.people(SYSTEM, **OPTIONS, path=path)
    found = stop.value.partial
    assert (found.runs_done, found.runs, found.complete) == (5, N, False)
    assert "STOPPED" in codes(found) and found.spread("rms_error")["fingers"] == 5
    assert int(np.isfinite(fl.load(path).rms_error).sum()) == 5


def test_ctrl_c_in_open_loop_does_not_lose_what_was_swept(monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(people_served, "_with_open_loop", stopped)
    with pytest.raises(fl.PeopleInterrupted) as stop:
        fl.people(SYSTEM, **OPTIONS)
    assert stop.value.partial.complete
