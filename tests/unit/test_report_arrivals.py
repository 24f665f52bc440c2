"""The stored study of effects that comes with the report: complete, told as it is, and drawn."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.report.effect_arrivals import EFFECTS, LAWS, SPEEDS_MM_S, figure_arrivals, rows, stored


def test_it_has_every_effect_of_the_library_under_every_law_at_every_speed():
    found = stored()
    assert len(EFFECTS) == 12 and set(EFFECTS) <= fl.rendering.LIBRARY.keys()
    assert found.effects == list(EFFECTS) and list(found.laws) == list(LAWS)
    assert (found.speeds_mm_s, found.seed) == (SPEEDS_MM_S, 11)
    for law in found.laws:
        for told in ("contrast", "contrast_low", "contrast_high", "rms_error_n", "error_felt", "spread_n"):
            assert found.values(law, told).shape == (12, len(SPEEDS_MM_S))
            assert np.all(found.values(law, told) > 0.0)
        low, middle, high = (found.values(law, f"contrast{end}") for end in ("_low", "", "_high"))
        assert np.all((low <= middle) & (middle <= high))


def test_its_first_number_is_the_spread_between_fingers():
    found = stored()
    opened, closed = (np.median(found.values(law, "spread_n")) for law in ("lookup", "notch_pi"))
    assert closed < 0.2 * opened
    assert f"differ by {1e3 * opened:.0f} mN open loop, by {1e3 * closed:.0f} mN with" in found.sentence


def test_its_table_has_a_column_for_each_law_and_the_spread_first():
    found = stored()
    heads, *table = rows(found)
    assert table[0] == ("between fingers (mN)", *(f"{1e3 * found.middle(law, 'spread_n'):.0f}" for law in found.laws))
    assert heads == ("", *(LAWS[law] for law in found.laws))
    grating = next(row for row in table if row[0] == "grating")
    percents = [100 * each for each in found.laws["notch_pi"]["grating"]["contrast"]]
    assert grating[1 + list(found.laws).index("notch_pi")] == " ".join(f"{each:.0f}" for each in percents)


def test_it_is_drawn_with_a_panel_for_each_effect():
    found = stored()
    figure = figure_arrivals(found)
    assert [axes.get_title("left") for axes in figure.axes[1:]] == found.effects
    line = figure.axes[1 + found.effects.index("rough")].lines[1 + list(found.laws).index("notch_pi")]
    assert line.get_ydata() == pytest.approx(found.laws["notch_pi"]["rough"]["contrast"])
