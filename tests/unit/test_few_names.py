"""A header with names for the first columns only: the others go by number, in a run as in `identify channels`."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.recordings.read import read_recording
from frictionloop.recordings.told import found
from frictionloop.recordings.whole import read_contents

RATE_HZ = 1000.0
VALUES = np.arange(50.0)[:, None] + np.arange(6.0) / 10


@pytest.fixture(params=[" ", "\t", ";", ","])
def path(tmp_path, request):
    """A table of six columns, of times and five of forces, three of which have names."""
    mark, columns = request.param, np.c_[np.arange(50) / RATE_HZ, VALUES[:, 1:]]
    written = tmp_path / "grip.txt"
    np.savetxt(written, columns, delimiter=mark, header=mark.join(("time_s", "Px", "Py")), comments="", fmt="%.6f")
    return str(written)


@pytest.mark.parametrize(("column", "k"), [("Py", 2), ("3", 3), (5, 5)])
def test_columns_without_a_name_are_read_by_number(path, column, k):
    recording = fl.Recording(path=path, column=column)
    assert read_recording(recording, RATE_HZ) == pytest.approx(VALUES[:, k])
    assert found(recording).head == "names in line 1 for 3 of 6 columns, from the left; the others go by number"


def test_a_run_takes_the_columns_that_the_list_of_channels_has(path):
    found = read_contents(path)
    assert [each.name for each in found.channels] == ["time", "Px", "Py", "3", "4", "5"]
    for channel in found.signals():
        taken = read_recording(fl.Recording(path=path, column=channel.name), RATE_HZ)
        assert taken == pytest.approx(np.asarray(channel.samples))


def test_one_that_is_not_there_is_refused_with_all_that_are(path):
    with pytest.raises(fl.FrictionloopError, match=r"is not there \(names in line 1 for 3 of 6 .* from 0 to 5"):
        read_recording(fl.Recording(path=path, column="6"), RATE_HZ)


@pytest.mark.parametrize("mark", [" ", ","])
def test_a_longer_row_among_decimal_points_is_no_decimal_comma(tmp_path, mark):
    (tmp_path / "f.txt").write_text("t_s Ft\n0.001 1.5\n0.002 2.5 3.5\n".replace(" ", mark))
    with pytest.raises(fl.FrictionloopError, match="line 3: t_s is in a row of 3 cells, of 2 columns") as refused:
        read_recording(fl.Recording(path=str(tmp_path / "f.txt"), column="Ft"), RATE_HZ)
    assert "comma" not in str(refused.value)
