"""What travels over the socket comes back as it was, and nothing else is taken for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.quantities import FrictionloopError
from frictionloop.studio.frames import MOST_EVENTS, Frame, events_in, pack, pack_map, unpack


@given(st.integers(1, 12), st.integers(0, 50), st.integers(0, 2**40), st.floats(0, 1e6))
def test_a_frame_comes_back_as_it_was(channels, rows, number, time_s):
    values = np.arange(channels * rows, dtype=np.float32).reshape(channels, rows)
    back = unpack(pack(Frame(number, time_s, 12.5, 1e-3, values)))
    assert (back.number, back.time_s, back.reached_ms) == (number % 2**32, time_s, 12.5)
    np.testing.assert_array_equal(back.rows, values)


@given(st.binary(max_size=200))
def test_other_bytes_are_no_frame(data):
    if data[:4] != b"\x01\x00\x00\x00":
        with pytest.raises(FrictionloopError):
            unpack(data)


@pytest.mark.parametrize("cut", [-1, 4])
def test_a_frame_of_another_length_is_refused(cut):
    data = pack(Frame(0, 0.0, np.nan, 1e-3, np.zeros((2, 3), np.float32)))
    with pytest.raises(FrictionloopError, match="2 channels of 3 rows"):
        unpack(data[:cut] if cut < 0 else data + bytes(cut))


def test_a_map_says_its_edges_and_spans_its_range():
    data = pack_map(np.array([[0.2, 0.4], [0.6, 0.3]]), -1.0, 1.0, -2.0, 2.0)
    assert np.frombuffer(data, "<u4", 3).tolist() == [2, 2, 2]
    np.testing.assert_allclose(np.frombuffer(data, "<f4", 6, offset=12), [-1, 1, -2, 2, 0.2, 0.6], rtol=1e-6)
    assert list(data[36:]) == [0, 128, 255, 64]


@pytest.mark.parametrize(
    "events",
    [
        np.zeros((0, 4)),
        np.zeros((MOST_EVENTS + 1, 4)),
        np.array([[np.nan, 0, 0, 0.5]]),
        np.array([[0, np.inf, 0, 0.5]]),
        np.array([[0, 0, 0, -0.1]]),
        np.array([[0, 0, 0, 1e9]]),
    ],
)
def test_wrong_pointer_events_are_refused(events):
    with pytest.raises(FrictionloopError, match="pointer"):
        events_in(events.astype("<f8").tobytes())


def test_a_pointer_without_pressure_has_no_load():
    assert np.isnan(events_in(np.array([[1.0, 2.0, 3.0, np.nan]]).tobytes())[0, 3])
