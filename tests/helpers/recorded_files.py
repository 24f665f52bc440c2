"""Files as recorders write them, made from columns over time: one function per format."""

from __future__ import annotations

import io
import struct

import h5py
import numpy as np
import scipy.io
from scipy.io import wavfile


def csv(path, columns, rate_hz):
    time = np.arange(len(next(iter(columns.values())))) / rate_hz
    table = np.column_stack([time, *columns.values()])
    header = ",".join(["Time (s)", *columns])
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.10g")


def european_csv(path, columns, rate_hz):
    """A preamble, quoted names, a row of units, semicolons and decimal commas."""
    time = np.arange(len(next(iter(columns.values())))) / rate_hz
    lines = ["Recorder;X100", f"Sample rate;{rate_hz:g}", ";".join(f'"{name}"' for name in ["Time", *columns])]
    lines.append(";".join(["[s]", *("[V]" for _ in columns)]))
    lines += [";".join(f"{x:.10g}".replace(".", ",") for x in row) for row in zip(time, *columns.values(), strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="cp1252")


def hdf5(path, columns, rate_hz):
    with h5py.File(path, "w") as file:
        group = file.create_group("daq")
        group.attrs["fs"] = rate_hz
        for name, values in columns.items():
            group[name] = values


def mat5(path, columns, rate_hz):
    scipy.io.savemat(path, {**columns, "fs": rate_hz, "comment": "a bench"})


def mat5_with_object(path, columns, rate_hz):
    """With an opaque object of MATLAB's (a table, a figure), on which SciPy's whosmat raises."""
    plain = io.BytesIO()
    scipy.io.savemat(plain, {**columns, "fs": rate_hz})
    path.write_bytes(plain.getvalue() + _opaque())


def mat73(path, columns, rate_hz):
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {**columns, "dt": 1 / rate_hz}.items():
            file[name] = np.atleast_2d(values)
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
        file["settings"] = np.zeros((1, 6), dtype=np.uint32)
        file["settings"].attrs["MATLAB_class"] = np.bytes_("table")
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + struct.pack("<HH", 0x0200, 0x4D49))


def npz(path, columns, rate_hz):
    np.savez(path, **columns, sr=rate_hz)


def wav(path, columns, rate_hz):
    """32 bit floats: a WAV file has no names."""
    wavfile.write(path, int(rate_hz), np.column_stack(list(columns.values())).astype(np.float32))


def lvm(path, columns, rate_hz):
    count = len(columns)
    rows = [
        f"\t{line}"
        for line in map("\t".join, (map("{:.10g}".format, row) for row in zip(*columns.values(), strict=True)))
    ]
    size = len(rows)
    head = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t.",
        "Multi_Headings\tNo", "X_Columns\tNo", "Time_Pref\tAbsolute", "Date\t2026/03/04", "Time\t12:00:00",
        "***End_of_Header***\t", "", f"Channels\t{count}", "\t".join(["Samples", *[str(size)] * count]),
        "\t".join(["Y_Unit_Label", *["V"] * count]), "\t".join(["Delta_X", *[f"{1 / rate_hz:.12g}"] * count]),
        "***End_of_Header***\t", "\t".join(["X_Value", *columns, "Comment"]),
    ]  # fmt: skip
    path.write_text("\n".join(head + rows) + "\n")


def tdms(path, columns, rate_hz):
    from nptdms import ChannelObject, TdmsWriter

    said = {"wf_increment": 1 / rate_hz, "unit_string": "V"}
    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("daq", name, values, said) for name, values in columns.items()])


AXIS = ("spec_data_type", "len_unit_exp", "force_unit_exp", "temp_unit_exp", "axis_lab", "axis_units_lab")


def uff58(path, columns, rate_hz):
    import pyuff

    time = np.arange(len(next(iter(columns.values())))) / rate_hz
    file = pyuff.UFF(str(path))
    for name, values in columns.items():
        node = dict.fromkeys(("rsp_node", "rsp_dir", "ref_node", "ref_dir"), 1)
        words = {"id1": name, "rsp_ent_name": "NONE", "ref_ent_name": "NONE"}
        samples = {"data": values, "x": time, "abscissa_spacing": 1}
        axes = [f"{axis}_{what}" for axis in ("abscissa", "ordinate", "orddenom", "z_axis") for what in AXIS]
        blank = {each: "NONE" if each.endswith("lab") else 0 for each in axes}
        file.write_sets(blank | {"type": 58, "binary": 0, "func_type": 1} | node | words | samples, "add")


FORMATS = {
    "time.csv": csv, "european.csv": european_csv, "file.h5": hdf5, "five.mat": mat5, "object.mat": mat5_with_object,
    "seven.mat": mat73, "file.npz": npz, "file.wav": wav, "file.lvm": lvm, "file.tdms": tdms, "file.uff": uff58,
}  # fmt: skip


def _element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def _opaque():
    """Return a variable of class mxOPAQUE (17), as MATLAB stores its objects in MAT 5."""
    words = np.array([[0xDD000000, 2, 1, 1, 1, 1]], dtype="<u4")
    flags = _element(6, struct.pack("<II", 13, 0)) + _element(5, struct.pack("<ii", 1, 6))
    inner = _element(14, flags + _element(1, b"") + _element(6, words.tobytes()))
    head = _element(6, struct.pack("<II", 17, 0))
    return _element(14, head + _element(1, b"settings") + _element(1, b"MCOS") + _element(1, b"table") + inner)
