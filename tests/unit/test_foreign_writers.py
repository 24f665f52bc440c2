"""Files of other writers (h5py, SciPy, npTDMS) with drawn channels: each has its own samples, unit, scale and rate."""

from __future__ import annotations

from typing import NamedTuple

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nptdms import ChannelObject, GroupObject, TdmsWriter, types
from scipy.io import savemat

from frictionloop.parameters import Recording
from frictionloop.recordings import hdf5_checks
from frictionloop.recordings.file_opening import read_contents
from frictionloop.recordings.force_channel import scaled

NEWTONS = {"N": 1.0, "mN": 1e-3, "kN": 1e3}


class Drawn(NamedTuple):
    """One channel as it is written."""

    raw: np.ndarray
    unit: str
    rate_hz: int
    told: str
    """How its rate is told: by itself, by its group, by a step, by times."""
    slope: float
    offset: float

    @property
    def values(self):
        return self.raw * self.slope + self.offset

    @property
    def times_s(self):
        return np.arange(self.raw.size) / self.rate_hz


RAW = st.builds(
    np.array,
    st.lists(st.integers(-2000, 2000), min_size=8, max_size=20, unique=True),
    st.sampled_from(["<i2", ">i4", "<f4", ">f8"]),
)
CHANNEL = st.builds(
    Drawn, RAW, st.sampled_from([*NEWTONS]), st.integers(20, 20_000),
    st.sampled_from(["self", "group", "step", "times"]), st.sampled_from([1.0, 0.25, -3e-4]),
    st.sampled_from([0.0, 1.5, -40.0]),
)  # fmt: skip
CHANNELS = st.lists(CHANNEL, min_size=1, max_size=4)


@pytest.fixture(scope="module", autouse=True)
def look_in_this_process():
    """A process of its own for each example would take most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hdf5_checks, "_looked_through_elsewhere", hdf5_checks.looked_through)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


def holds(path, expected):
    """Hold a file against the channels that it was written from, by name."""
    there = {each.name: each for each in read_contents(path).signals()}
    assert set(there) == set(expected)
    for name, drawn in expected.items():
        assert there[name].unit == drawn.unit
        np.testing.assert_allclose(np.asarray(there[name].samples, float), drawn.values, rtol=1e-6)
        read = scaled(Recording(path=str(path), column=name))
        np.testing.assert_allclose(read.force, NEWTONS[drawn.unit] * drawn.values, rtol=1e-6)
        assert read.rate_hz == pytest.approx(drawn.rate_hz, rel=1e-6)


@settings(max_examples=40)
@given(CHANNELS, st.booleans())
def test_hdf5_of_h5py(folder, drawn, compound):
    path = folder / "file.h5"
    with h5py.File(path, "w") as file:
        for k, each in enumerate(drawn):
            group = file.create_group(f"group {k}")
            raw = (
                np.array([*zip(each.raw, each.raw, strict=True)], [("a", each.raw.dtype), ("b", "f8")])
                if compound
                else each.raw
            )
            written = group.create_dataset("ft", data=raw)
            written.attrs["units"] = each.unit
            if not compound:
                written.attrs.update({"scale_factor": each.slope, "add_offset": each.offset})
            if each.told == "times" and not compound:
                group["t"] = each.times_s
                group["t"].attrs["unit"] = "s"
            elif each.told == "step":
                group["dt"] = 1.0 / each.rate_hz
            else:
                (written if each.told == "self" else group).attrs["fs"] = each.rate_hz
    plain = [each._replace(slope=1.0, offset=0.0) if compound else each for each in drawn]
    fields = ("/a", "/b") if compound else ("",)
    holds(path, {f"group {k}/ft{field}": each for k, each in enumerate(plain) for field in fields})


@settings(max_examples=40)
@given(CHANNELS, st.sampled_from(["row", "column"]), st.booleans())
def test_mat_of_scipy(folder, drawn, one_as, compressed):
    path, tree = folder / "file.mat", {}
    for k, each in enumerate(drawn):
        tree[f"g{k}"] = {f"ft_{each.unit}": each.values}
        rates = {"step": {"dt": 1.0 / each.rate_hz}, "times": {"t_s": each.times_s}}
        tree[f"g{k}"] |= rates.get(each.told, {"fs": each.rate_hz})
    savemat(path, tree, oned_as=one_as, do_compression=compressed)
    holds(path, {f"g{k}/ft_{each.unit}": each for k, each in enumerate(drawn)})


@settings(max_examples=40)
@given(CHANNELS)
def test_tdms_of_nptdms(folder, drawn):
    path, objects = folder / "file.tdms", []
    for k, each in enumerate(drawn):
        raw = each.raw.astype(each.raw.dtype.newbyteorder("<"))
        linear = {"Scale_Type": "Linear", "Linear_Slope": each.slope, "Linear_Y_Intercept": each.offset}
        said = {f"NI_Scale[0]_{name}": value for name, value in linear.items()}
        said |= {"NI_Scale[0]_Linear_Input_Source": types.Uint32(0xFFFFFFFF), "NI_Number_Of_Scales": types.Uint32(1)}
        said |= {"unit_string": each.unit}
        if each.told == "times":
            objects.append(ChannelObject(f"group {k}", "t", each.times_s, {"unit_string": "s"}))
        else:
            said["wf_increment"] = 1.0 / each.rate_hz
        objects += [GroupObject(f"group {k}"), ChannelObject(f"group {k}", "ft", raw, said)]
    with TdmsWriter(path) as file:
        file.write_segment(objects)
    holds(path, {f"group {k}/ft": each for k, each in enumerate(drawn)})
