"""What shards cost, and how large a population can be: 2 % of a million fingers on the bench, closed loop, 5 s.

python -m benchmarks.shards             # two to four minutes on two cores
python -m benchmarks.shards --write     # the same, into benchmarks/results/shards.md
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FINGERS, PART, FEW, SHARDS, DURATION_S = 1_000_000, 20_000, 4_000, 64, 5.0
RESULTS = Path(__file__).parent / "results" / "shards.md"


def run(folder, fingers, shards):
    """Sweep over fingers in parts, in this process; print processor and wall time, s, and most memory, MB."""
    import frictionloop as fl

    bench = fl.bench().evolve(fl.RETUNED)
    fl.sweep(bench, fl.fingers(256, 2), 0.1, progress=False)  # reads what is compiled
    before, start = time.process_time(), time.perf_counter()
    for part in range(1, shards + 1):
        fl.sweep(bench, fl.fingers(fingers, 1), DURATION_S, path=folder, shard=(part, shards), progress=False)
    spent = time.process_time() - before, time.perf_counter() - start
    print(json.dumps([*spent, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3]))


def measured(folder, fingers, shards):
    """Return what `run` prints in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.shards", "--run", folder, str(fingers), str(shards)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def page():
    """Return what was measured as a table."""
    import frictionloop as fl

    load = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        _, _, few_mb = measured(f"{folder}/few", FEW, 1)
        cpu, wall, mb = measured(f"{folder}/one", PART, 1)
        in_parts, _, parts_mb = measured(f"{folder}/parts", PART, SHARDS)
        size = sum(each.stat().st_size for each in Path(folder, "one").iterdir())
        same = fl.open_sweep(f"{folder}/one").compute().identical(fl.open_sweep(f"{folder}/parts").compute())
    a_shard_s, whole_s = (in_parts - cpu) / SHARDS, cpu / PART * FINGERS
    rows = [
        ("one process, processor time", f"{cpu:.0f} s, {1e3 * cpu / PART:.2f} ms a finger"),
        (f"{SHARDS} shards, processor time", f"{in_parts:.0f} s, {a_shard_s:.2f} s more a shard"),
        ("the same bits", "yes" if same else "no"),
        (f"most memory: {FEW:,}, {PART:,}, {SHARDS} shards", f"{few_mb:.0f}, {mb:.0f}, {parts_mb:.0f} MB"),
        ("file", f"{size / 1e6:.1f} MB, {size / PART:.0f} bytes a finger"),
        (f"so {FINGERS:,} fingers", f"{whole_s / 3600:.1f} core-hours, {size / PART * FINGERS / 1e6:.0f} MB"),
        (f"{SHARDS} shards of them", f"{100 * a_shard_s * SHARDS / whole_s:+.1f} %; goal at most 5 %"),
    ]
    lines = [f"| {PART:,} fingers, bench, closed loop, {DURATION_S:g} s | |", "|---|---|"]
    lines += [f"| {what} | {value} |" for what, value in rows]
    return "\n".join(
        [*lines, "", f"{wall:.0f} s on {os.cpu_count()} cores; load of the machine before: {load:.1f}.", ""]
    )


if __name__ == "__main__":
    if "--run" in sys.argv:
        run(sys.argv[-3], int(sys.argv[-2]), int(sys.argv[-1]))
    else:
        print(text := page())
        if "--write" in sys.argv:
            RESULTS.write_text(text, encoding="utf-8")
