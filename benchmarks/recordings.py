"""Measure how a long recording is read: memory, time, and the time to the first picture.

    python benchmarks/recordings.py                      10 minutes of 8 channels at 100 kHz, one format after the other
    python benchmarks/recordings.py --minutes 1 h5 csv   shorter, and these formats

Files are made in a temporary folder and deleted: 2 GB each as float32, about 5 GB as CSV. Each measurement is a process
of its own, whose peak of resident memory is its own too. Results go to results/recordings.json.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

RATE, LINES, BLOCK = 100_000, 8, 1_000_000
HERE = Path(__file__).parent
MAP = """
[channels.{name}]
column = {column}
unit = "N"
"""


def blocks(minutes: float) -> Iterator[np.ndarray]:
    """Yield float32 rows: a hit on a resonance of 1.6 kHz every 5 s in channel 0, noise in all."""
    draw, total = np.random.default_rng(0), int(minutes * 60 * RATE)
    for first in range(0, total, BLOCK):
        rows = min(BLOCK, total - first)
        found = 1e-3 * draw.standard_normal((rows, LINES), dtype=np.float32)
        for onset in range(-first % (5 * RATE) + RATE, rows, 5 * RATE):
            t = np.arange(rows - onset) / RATE
            found[onset:, 0] += draw.uniform(0.5, 1) * np.exp(-np.pi * 1600 / 40 * t) * np.sin(2 * np.pi * 1600 * t)
        yield found


def write_h5(path: Path, minutes: float, matlab: bool = False) -> None:
    import h5py

    shape = (LINES, int(minutes * 60 * RATE)) if matlab else (int(minutes * 60 * RATE), LINES)
    with h5py.File(path, "w") as file:
        data = file.create_dataset("daq", shape, "f4", chunks=(LINES, 65536) if matlab else (65536, LINES))
        data.attrs["fs"] = RATE
        if matlab:
            data.attrs["MATLAB_class"] = np.bytes_("single")
            file["fs"] = np.array([[float(RATE)]])
            file["fs"].attrs["MATLAB_class"] = np.bytes_("double")
        at = 0
        for block in blocks(minutes):
            rows = (slice(at, at + len(block)), slice(None))
            data[rows[::-1] if matlab else rows] = block.T if matlab else block
            at += len(block)


def write_wav(path: Path, minutes: float) -> None:
    import struct

    size = int(minutes * 60 * RATE) * LINES * 4
    with open(path, "wb") as file:
        form = struct.pack("<HHIIHH", 3, LINES, RATE, RATE * LINES * 4, LINES * 4, 32)
        file.write(b"RIFF" + struct.pack("<I", 36 + size) + b"WAVEfmt " + struct.pack("<I", 16) + form)
        file.write(b"data" + struct.pack("<I", size))
        for block in blocks(minutes):
            file.write(block.tobytes())


def write_tdms(path: Path, minutes: float) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as file:
        for block in blocks(minutes):
            told = {"wf_increment": 1 / RATE}
            file.write_segment([ChannelObject("daq", f"ch{k}", block[:, k], told) for k in range(LINES)])


def write_csv(path: Path, minutes: float) -> None:
    with open(path, "w") as file:
        file.write(",".join(f"ch{k}" for k in range(LINES)) + "\n")
        for block in blocks(minutes):
            np.savetxt(file, block, fmt="%.6g", delimiter=",")


FORMATS: dict[str, tuple[str, Callable[[Path, float], None], str | int]] = {
    "h5": ("daq.h5", write_h5, "daq[:, 0]"),
    "mat": ("daq.mat", lambda path, minutes: write_h5(path, minutes, matlab=True), "daq[:, 0]"),
    "wav": ("daq.wav", write_wav, 0),
    "tdms": ("daq.tdms", write_tdms, "ch0"),
    "csv": ("daq.csv", write_csv, "ch0"),
}


def measured(work: str, path: Path, column: str | int) -> dict[str, float]:
    """Run one kind of work in a process of its own."""
    words = [sys.executable, __file__, "--work", work, str(path), json.dumps(column)]
    return json.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout.splitlines()[-1])


def child(work: str, path: Path, column: str | int) -> None:
    """Do the work and print how long it took, and the peak of resident memory in MB."""
    began = time.perf_counter()
    if work == "first picture":
        import frictionloop as fl
        from frictionloop.identification.file_overview import first_look

        fl.plot(first_look(path), path.with_suffix(".png"))
    elif work == "channels":
        from frictionloop.identification import channels

        channels(path, RATE, progress=False)
    else:
        from frictionloop.identification.project_analysis import analyse
        from frictionloop.identification.project_entry_result import Sensor
        from frictionloop.identification.project_file import Take

        take = Take(kind=work, files=(path.name,), rate_hz=RATE, channels={"f_m": {"column": column, "unit": "N"}})
        analyse(take, path.parent, Sensor())
    seconds = time.perf_counter() - began
    print(json.dumps({"seconds": seconds, "mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))


def main() -> None:
    if sys.argv[1:2] == ["--work"]:
        child(sys.argv[2], Path(sys.argv[3]), json.loads(sys.argv[4]))
        return
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("formats", nargs="*", help=f"of {', '.join(FORMATS)}; all if none is given")
    parser.add_argument("--minutes", type=float, default=10.0)
    options = parser.parse_args()
    if unknown := [each for each in options.formats if each not in FORMATS]:
        parser.error(f"formats: {unknown[0]!r}: must be of {', '.join(FORMATS)}")
    results = HERE / "results" / "recordings.json"
    found = json.loads(results.read_text()) if results.exists() else {}
    for form in options.formats or FORMATS:
        name, write, column = FORMATS[form]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            write(path, options.minutes)
            row: dict[str, object] = {"minutes": options.minutes, "file_mb": path.stat().st_size / 1e6}
            for work in ("first picture", "channels", "quiet", "hits"):
                row[work] = measured(work, path, column)
                print(form, work, row[work], flush=True)
        found[form] = row
        results.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
