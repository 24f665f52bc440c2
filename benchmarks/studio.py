"""Speed of the studio in a browser: frames, pointer to force, the engine, viewers, bytes, start; and its memory.

python -m benchmarks.studio                  # the row, half a minute
python -m benchmarks.studio --soak-min 30    # memory of page and server, as `make soak` does

Pointer to force is the time from the arrival of an event of a 60 Hz pointer in the page to that of the first force that
knows of it, less the 16.7 ms that the finger follows late.

It needs the extra `studio`, playwright, and a chromium on the PATH. Nothing is stored: the machine must be quiet.
"""

import argparse
import os
import re
import sys
import time

import numpy as np
from benchmarks.studio_pages import cpu_s, opened, others_s, resident_mb, served, stroke, watched

import frictionloop as fl
from frictionloop.live.live_engines import TwinEngine

GOALS = {
    "frames a second, median": (">=", 55.0, ""),
    "pointer to force, 95 %": ("<=", 10.0, "ms"),
    "row of twelve fingers, frames a second": (">=", 25.0, ""),
    "engine, two loops, share of a core": ("<=", 15.0, "%"),
    "page": ("<=", 400.0, "kB"),
    "first frame after the server is up": ("<=", 1.0, "s"),
    "server up, warm cache": ("<=", 2.5, "s"),
}
QUIET = 5.0
"""Share of a core, %, that others may take: above it times are those of a busy machine (assumed)."""
VIEWERS, SECONDS, ROW_SECONDS = 8, 15, 6
GROWS_MB = {"page": 2.0, "server": 8.0}
"""By how much memory may grow from the first third to the last (assumed: a tenth of either)."""


def engine_share(seconds=4.0):
    """Time of both loops per time that they simulate, %."""
    engine = TwinEngine(fl.bench().evolve({"setpoint": {"kind": "effect"}}))
    path, times = np.zeros((25, 3)), []
    path[:, 1:] = 0.04, 0.5
    for block in range(round(200 * seconds)):
        path[:, 0] = 0.02 * np.sin(block / 100)
        begun = time.perf_counter()
        engine.advance(path)
        times.append(time.perf_counter() - begun)
    return 100.0 * float(np.median(times)) * 200.0


def row():
    """Measure everything once."""
    with served() as (address, process, up_s), opened(address) as page:
        first_s = 1e-3 * page.evaluate("window.firstFrame")
        page.wait_for_timeout(1000)
        size = page.evaluate(
            "performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation'))"
            ".reduce((sum, each) => sum + each.encodedBodySize, 0)"
        )
        with watched(address, VIEWERS - 1):
            before, others, begun = cpu_s(process.pid), others_s(), time.perf_counter()
            told = stroke(page, SECONDS)[2:]
            seconds = time.perf_counter() - begun
            share = 100.0 * (cpu_s(process.pid) - before) / seconds
            beside = 100.0 * (others_s() - others) / seconds
            page.click("#crowd-on")
            while page.text_content("#crowd-told").startswith("Getting"):
                time.sleep(0.1)
            people = stroke(page, ROW_SECONDS)[2:]
    frames = [float(found[1]) for each in told if (found := re.match(r"(\d+) frames", each))]
    late = [float(found[1]) for each in told if (found := re.search(r"95 %: (-?\d+) ms", each))]
    middle = np.median([float(found[1]) for each in told if (found := re.search(r"to force (-?\d+) ms", each))])
    print(f"{VIEWERS} viewers; the whole server took {share:.0f} % of a core; pointer to force, median {middle:.0f} ms")
    print(
        f"what else ran took {beside:.0f} % of a core meanwhile"
        + ("; measure again without it" if beside > QUIET else "")
    )
    return {
        "frames a second, median": float(np.median(frames)),
        "pointer to force, 95 %": float(np.median(late)),
        "row of twelve fingers, frames a second": float(
            np.median([float(re.search(r"twelve fingers (\d+)", each)[1]) for each in people])
        ),
        "engine, two loops, share of a core": engine_share(),
        "page": size / 1000.0,
        "first frame after the server is up": first_s,
        "server up, warm cache": up_s,
    }


def soak(minutes):
    """Watch the memory of page and server (MB), and return what grew too much."""
    found = {"page": [], "server": []}
    with served() as (address, process, _), opened(address) as page:
        line, end = page.context.new_cdp_session(page), time.monotonic() + 60.0 * minutes
        while time.monotonic() < end:
            time.sleep(5.0)
            line.send("HeapProfiler.collectGarbage")
            found["page"].append(line.send("Runtime.getHeapUsage")["usedSize"] / 1e6)
            found["server"].append(resident_mb(process.pid))
    grew = []
    for name, sizes in found.items():
        third = max(len(sizes) // 3, 1)
        early, late = (float(np.median(part)) for part in (sizes[third // 2 : third + third // 2], sizes[-third:]))
        print(f"{name}: {early:.1f} MB, {late:.1f} MB in the last third (may grow by {GROWS_MB[name]:.0f} MB)")
        grew += [name] if late - early > GROWS_MB[name] else []
    return grew


def main():
    """Print the row, or the memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--soak-min", type=float, help="watch memory for so many minutes instead")
    options = parser.parse_args()
    if options.soak_min:
        grew = soak(options.soak_min)
        sys.exit(f"memory grows: {', '.join(grew)}" if grew else 0)
    print(f"load of the machine before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    for name, value in row().items():
        sign, goal, unit = GOALS[name]
        met = value >= goal if sign == ">=" else value <= goal
        print(f"{name:39} {value:7.1f} {unit:3} (goal {sign} {goal:g}) {'' if met else 'MISSED'}")


if __name__ == "__main__":
    main()
