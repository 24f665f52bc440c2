"""Half an hour of recording in flat memory, and what that says of a day."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
RATE_HZ, HALF_HOUR_S, MOST_MB = 5000, 1800, 300
MINUTES = 5, 29
DAY = 24 * 60
RECORD = f"""
import resource, sys
sys.path.insert(0, {str(HERE)!r})
import board
from frictionloop.device.device import Device

def told_mb():
    with open("/proc/self/status") as status:
        lines = dict(line.split(":", 1) for line in status)
    return int(lines["VmRSS"].split()[0]) / 1e3, int(lines["VmHWM"].split()[0]) / 1e3

def progress(rows):
    for minute in MINUTES:
        if minute not in seen and rows > minute * 60 * {RATE_HZ}:
            seen[minute] = told_mb()[0]

MINUTES, seen, there = {MINUTES}, {{}}, board.Board()
run = Device(lambda: board.Line(there)).run(0.5, {HALF_HOUR_S}, path="run.h5", progress=progress)
print(*seen.values(), told_mb()[1], run.sizes["time"], run.attrs["lost_samples"])
"""


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="only Linux tells a process its memory")
def test_half_an_hour_in_flat_memory(tmp_path: Path) -> None:
    said = subprocess.run([sys.executable, "-c", RECORD], cwd=tmp_path, capture_output=True, text=True, check=True)
    early, late, largest, rows, lost = map(float, said.stdout.split())
    assert (rows, lost) == (HALF_HOUR_S * RATE_HZ, 0)
    assert largest < MOST_MB
    after_a_day = early + (late - early) / (MINUTES[1] - MINUTES[0]) * DAY
    assert after_a_day < MOST_MB, f"{early:g} MB after 5 min, {late:g} MB after 29 min: {after_a_day:g} MB after a day"
