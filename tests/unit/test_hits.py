"""Hits found by their noise: either polarity, every defect named, the rest used; H1."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.identification import fit_resonance, pick_hits, response, rigs

RIG = rigs.hammer_rig(seed=3)
RATE = 5000.0


def changed(**columns):
    return RIG.assign({name: ("time", values, RIG[name].attrs) for name, values in columns.items()})


def verdicts(run, **named):
    return [each.verdict for each in pick_hits(run, 0.5, **named).table]


def test_all_hits_of_a_clean_rig_are_good():
    found = pick_hits(RIG, 0.5)
    assert found.good == 10 and not found.inverted and found.channel == "hammer"
    assert found.good == len(found.table) == 10


@pytest.mark.parametrize(("hammer", "reading"), [(-1, 1), (1, -1), (-1, -1)])
def test_either_polarity_gives_the_same_resonance(hammer, reading):
    run = changed(hammer=hammer * RIG.hammer.values, f_m=reading * RIG.f_m.values)
    found, plain = fit_resonance(response(run)), fit_resonance(response(RIG))
    assert pick_hits(run, 0.5).inverted == (hammer < 0)
    assert found.resonance.value == pytest.approx(plain.resonance.value, rel=1e-4)
    assert found.gain.value == pytest.approx(reading * plain.gain.value, rel=1e-3)


def test_a_small_hit_between_large_ones_is_found():
    """A share of the largest would miss it, the noise does not."""
    scale = np.ones(RIG.sizes["time"])
    scale[15000:20000] = 0.12
    found = pick_hits(changed(hammer=RIG.hammer.values * scale, f_m=RIG.f_m.values * scale), 0.5)
    assert len(found.table) == 10 and found.table[3].peak < 0.15 * found.table[2].peak


def test_a_tenth_of_a_piece_is_before_its_hit():
    found, above = pick_hits(RIG, 0.5), RIG.hammer.values > 0.02
    rises = np.flatnonzero(above & ~np.roll(above, 1))
    first = rises[np.diff(rises, prepend=-5000) > 2500]
    np.testing.assert_allclose(np.array(found.starts) + 0.1 * 2500, first, atol=2)


@pytest.mark.parametrize(("share", "verdict"), [(0.09, "good"), (0.11, "double")])
def test_a_second_pulse_above_a_tenth_of_the_first_is_a_bounce(share, verdict):
    hammer = RIG.hammer.values.copy()
    first = np.flatnonzero(hammer > 0.02)[0]
    hammer[first + 40 : first + 49] = share * hammer[first : first + 20].max() * np.hanning(9)
    assert verdicts(changed(hammer=hammer)) == [verdict] + ["good"] * 9


@pytest.mark.parametrize(("share", "verdict"), [(0.009, "good"), (0.011, "still ringing")])
def test_a_reading_that_swings_by_a_hundredth_of_the_hit_before_it_still_rings(share, verdict):
    reading, onset = RIG.f_m.values.copy(), np.flatnonzero(RIG.hammer.values > 0.02)[0]
    before = slice(onset - 252, onset - 2)
    largest = np.max(np.abs(reading[onset : onset + 2000] - np.median(reading)))
    reading[before] += share * largest * math.sqrt(2.0) * np.sin(2 * np.pi * 100 * np.arange(250) / RATE)
    assert verdicts(changed(f_m=reading)) == [verdict] + ["good"] * 9


def test_each_defect_is_named_and_the_rest_is_used():
    hammer, reading = RIG.hammer.values.copy(), RIG.f_m.values.copy()
    at = [round(each.time_s * RATE) for each in pick_hits(RIG, 0.5).table]
    hammer[at[1] + 100 : at[1] + 110] += 0.3 * np.hanning(10)  # bounces 20 ms
    hammer[at[4] : at[4] + 20] = np.minimum(2.0 * hammer[at[4] : at[4] + 20], 0.7)
    reading[at[6] - 400 : at[6]] += 0.1 * np.sin(2 * np.pi * 145 * np.arange(400) / RATE)  # somebody has touched it
    found = pick_hits(changed(hammer=hammer, f_m=reading).isel(time=slice(0, at[9] + 1000)), 0.5)
    named = {each.number: each.verdict for each in found.table if each.verdict != "good"}
    assert named == {2: "double", 5: "clipped", 7: "still ringing", 10: "cut off"}
    assert "bounces 20" in found.table[1].reason and "at the end" in found.table[9].reason
    assert fit_resonance(response(changed(hammer=hammer, f_m=reading))).resonance.value == pytest.approx(145, abs=0.1)


def test_a_clipped_reading_is_named_and_no_gain_comes_of_it():
    reading = np.clip(RIG.f_m.values, -0.5, 0.5)
    assert set(verdicts(changed(f_m=reading))) == {"clipped"}
    with pytest.raises(fl.FrictionloopError, match=r"good hits = 0.*clipped"):
        response(changed(f_m=reading))


def test_exclusion_by_hand():
    found = pick_hits(RIG, 0.5, exclude=[2, 5])
    assert found.good == 8 and {hit.reason for hit in found.table if hit.verdict != "good"} == {"excluded by hand"}
    with pytest.raises(fl.FrictionloopError, match="must be from 1 to 10"):
        pick_hits(RIG, 0.5, exclude=[11])


def test_several_recordings_are_one_measurement():
    both = response([RIG, rigs.hammer_rig(seed=4)])
    assert both.hits == 20
    assert fit_resonance(both).resonance.standard_error < fit_resonance(response(RIG)).resonance.standard_error
    slow = rigs.hammer_rig(rate_hz=2000.0)
    with pytest.raises(fl.FrictionloopError, match="must be one"):
        response([RIG, slow])


def test_h1_is_that_of_pyfrf():
    import pyFRF

    found = pick_hits(RIG, 0.5)
    rows = np.array(found.starts)[:, None] + np.arange(found.length)
    force, reading = (RIG[name].values[rows] for name in ("hammer", "f_m"))
    force, reading = (each - each.mean(axis=1, keepdims=True) for each in (force, reading))
    other = pyFRF.FRF(int(RATE), exc=force, resp=reading, exc_type="f", resp_type="d", fft_len=found.length)
    mine = response(RIG)
    band = (mine.frequency_hz > 20) & (mine.frequency_hz < 400)
    h2 = mine.response / mine.coherence
    for name, here in (("H1", mine.response), ("H2", h2)):
        np.testing.assert_allclose(here[band], np.ravel(other.get_FRF(name))[1:][band], rtol=1e-9)
