"""The wiring of a board: words of the table, counts and back, and nothing of it in a simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.device.simulated_boards import Converters
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.loop.sweep_points import fingerprint, points_of
from frictionloop.quantities.protocol_schema import parameter_words
from frictionloop.sensing.measurement import Measurement

WIRED = {
    "board.force_axes": 2,
    "board.force_zero_counts": (120, -45),
    "board.force_n_per_count": -6.5e-5,
    "board.across_n_per_count": 7e-5,
    "board.load_zero_counts": -31000,
    "board.load_n_per_count": 1.1e-4,
    "board.position_m_per_count": -2e-6,
    "board.ceiling_um": 0.5,
    "board.ramp_s": 0.04,
    "board.force_limit_n": 1.75,
}


def words(system: fl.System, name: str) -> np.ndarray:
    """Return the numbers of a parameter."""
    word = parameter_words()[name]
    return firmware_words(system)[word.first : word.first + word.count]


def test_every_value_is_a_word_of_the_table():
    system = fl.bench().evolve(WIRED)
    assert words(system, "force.axes") == [2]
    assert words(system, "force.zero_counts").tolist() == [120, -45]
    assert words(system, "force.n_per_count") == pytest.approx([-6.5e-5, 7e-5])
    assert words(system, "touch.zero_counts") == [-31000]
    assert words(system, "touch.n_per_count") == pytest.approx([1.1e-4])
    assert words(system, "touch.m_per_count") == pytest.approx([-2e-6])
    assert words(system, "drive.ceiling_um") == [0.5]
    assert words(system, "drive.largest_um") == [2.5]
    assert words(system, "drive.ramp_um") == pytest.approx([2.5 / (0.04 * 5000)])
    assert words(system, "safety.force_limit_n") == [1.75]


def test_the_limit_of_the_force_follows_the_scale_whatever_its_sign():
    scaled = fl.bench().evolve({"board.force_n_per_count": -6e-5})
    assert words(scaled, "safety.force_limit_n") == pytest.approx([0.96 * 6e-5 * 2**15])


def test_a_limit_of_the_force_that_no_reading_passes_is_refused():
    scaled = fl.bench().evolve({"board.force_n_per_count": -6e-5})  # ends at 1.966 N
    assert words(scaled.evolve({"board.force_limit_n": 1.96}), "safety.force_limit_n") == pytest.approx(
        [1.96], rel=1e-3
    )
    with pytest.raises(fl.FrictionloopError, match=r"board\.force_limit_n = 2 N: .*1\.966, .*1\.887"):
        firmware_words(scaled.evolve({"board.force_limit_n": 2.0}))
    # A zero that is not in the middle leaves more on one side, and two channels read a larger magnitude than one.
    aside = {"board.force_zero_counts": (-20000, 0), "board.force_limit_n": 3.0}
    assert words(scaled.evolve(aside), "safety.force_limit_n") == [3.0]  # up to 3.166 N
    across = {"board.force_axes": 2, "board.across_n_per_count": 6e-5, "board.force_limit_n": 2.5}
    assert words(scaled.evolve(across), "safety.force_limit_n") == [2.5]  # up to 2.78 N
    for changes, limit_n in ((aside, 3.17), (across, 2.79)):
        with pytest.raises(fl.FrictionloopError, match=r"board\.force_limit_n = .*\b1\.887\b"):
            firmware_words(scaled.evolve(changes | {"board.force_limit_n": limit_n}))


def test_it_survives_a_file(tmp_path):
    system = fl.bench().evolve(WIRED)
    fl.write_toml(system, tmp_path / "bench.toml")
    text = (tmp_path / "bench.toml").read_text()
    assert "force_n_per_count = -6.5e-05  # N/count" in text
    assert fl.read_toml(tmp_path / "bench.toml") == system
    (tmp_path / "short.toml").write_text('preset = "bench"\n[board]\nceiling_um = 0.5\n')
    assert fl.read_toml(tmp_path / "short.toml") == fl.bench().evolve({"board.ceiling_um": 0.5})


@pytest.mark.parametrize(
    ("name", "word"),
    [("board.load_n_per_count", "touch.n_per_count"), ("board.position_m_per_count", "touch.m_per_count")],
)
def test_strokes_need_the_sensors_that_tell_them(name, word):
    with pytest.raises(fl.FrictionloopError, match=f"{name} = 0: must be other than 0"):
        firmware_words(fl.bench().evolve({name: 0.0}))
    assert words(fl.paper().evolve({name: 0.0}), word) == [0]


counts = st.integers(-2000, 2000)


@settings(max_examples=50, deadline=None)
@given(
    zeros=st.tuples(counts, counts, counts), force_n=st.floats(-2, 2), position_m=st.floats(-0.03, 0.03),
    load_n=st.floats(0, 3), sign=st.sampled_from([1, -1]),
)  # fmt: skip
def test_what_the_firmware_makes_of_the_counts_is_what_was_there(zeros, force_n, position_m, load_n, sign):
    system = fl.bench().evolve(
        {
            "board.force_zero_counts": zeros[:2],
            "board.load_zero_counts": zeros[2],
            "board.force_n_per_count": sign * 8e-5,
            "board.position_m_per_count": -1.2e-6,
        }
    )
    told = Converters(system).sample(Measurement(force_n, position_m, 0.0, load_n))
    assert sign * 8e-5 * (told.force - zeros[0]) == pytest.approx(force_n, abs=4.1e-5)
    assert told.across == zeros[1]
    assert -1.2e-6 * told.position == pytest.approx(position_m, abs=6.1e-7)
    assert 10 / 2**16 * (told.load - zeros[2]) == pytest.approx(load_n, abs=7.7e-5)


def test_a_converter_ends_and_a_channel_that_is_not_there_reads_nothing():
    none = fl.bench().evolve({"board.load_n_per_count": 0.0, "board.position_m_per_count": 0.0})
    assert Converters(none).sample(Measurement(9.0, 0.02, 0.0, 0.5)) == (32767, 0, 0, 0)
    assert Converters(fl.bench()).sample(Measurement(-9.0, 0.05, 0.0, 9.0)) == (-32768, 0, 32767, 32767)


def test_no_simulation_depends_on_it():
    plain, wired = fl.bench(), fl.bench().evolve(WIRED)
    assert structure(plain) == structure(wired)
    points = points_of({"controller.kp": [1.0]}, 1)
    one, other = (fingerprint(system, points, 0.1, 0.0, ["rms_error"]) for system in (plain, wired))
    assert one == other
