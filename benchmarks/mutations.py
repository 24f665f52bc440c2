"""Do the tests see what they should? One small wrong at a time in a copy of the sources, and the tests that are due.

    python benchmarks/mutations.py                 every mutation; prints the table and stores results/mutations.md
    python benchmarks/mutations.py notch jitter    those whose names contain a word; prints only

Exit status 1 if one survives. Only tests of the default suite run: what is marked slow does not count.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
SRC, CORE = "src/frictionloop/", "firmware/core/"


class Mutation(NamedTuple):
    """A text that is there once, what takes its place, and the test files that should see it."""

    name: str
    file: str
    old: str
    new: str
    tests: str


MUTATIONS = [
    Mutation(
        "disturbance pushes the other way",
        SRC + "loop/kernel/bench_tile.py",
        "fma(finger[0].direction, dist",
        "fma(-finger[0].direction, dist",
        "unit/test_bench_closed_form.py reference/test_bench_solver.py",
    ),
    Mutation(
        "half of the delay's rest",
        SRC + "loop/kernel/tile_compatibility.py",
        "return whole, rest if",
        "return whole, 0.5 * rest if",
        "unit/test_switch.py reference/test_linear_against_simulator.py reference/test_independent_solver.py",
    ),
    Mutation(
        "PI clamps at 0, not at the floor",
        SRC + "control/pi.py",
        "u = min(max(v, low), high)",
        "u = min(max(v, 0.0), high)",
        "unit/test_pi.py unit/test_switch.py firmware/test_control.py",
    ),
    Mutation(
        "no anti-windup",
        SRC + "control/pi.py",
        "integral = integral if pushes else fma(",
        "integral = fma(",
        "unit/test_pi.py unit/test_switch.py firmware/test_control.py",
    ),
    Mutation(
        "a law that is wrong drives on",
        CORE + "app_control.c",
        "u >= clamp.low && u <= clamp.high && sum == 0",
        "sum == 0",
        "firmware/test_board_law.py",
    ),
    Mutation(
        "friction falls as a^1.98",
        SRC + "physics/vibration.py",
        "return exp2(-y * fma(",
        "return exp2(-(y**0.98) * fma(",
        "unit/test_friction.py unit/test_friction_limit.py unit/test_bench_closed_form.py",
    ),
    Mutation(
        "Stribeck's speed 20 % off",
        SRC + "physics/limit_scaling.py",
        "(1e-3 * friction.slow_mm_s) ** 2",
        "(1.2e-3 * friction.slow_mm_s) ** 2",
        "unit/test_friction_limit.py unit/test_stick_slip.py",
    ),
    Mutation(
        "occlusion 5 % slower",
        SRC + "physics/limit_scaling.py",
        "math.exp(-dt / friction.occlusion_s)",
        "math.exp(-dt / (1.05 * friction.occlusion_s))",
        "unit/test_friction_limit.py unit/test_bench_closed_form.py unit/test_bench_properties.py",
    ),
    Mutation(
        "load exponent 1",
        SRC + "physics/limit_scaling.py",
        "load_exponent=friction.load_exponent,",
        "load_exponent=1.0,",
        "unit/test_friction_limit.py unit/test_bench_closed_form.py",
    ),
    Mutation(
        "plate's pole 2 % slow on the bench",
        SRC + "physics/plate.py",
        "rate = -2.0 * math.pi *",
        "rate = -1.96 * math.pi *",
        "unit/test_plate_envelope.py unit/test_bench_closed_form.py reference/test_bench_solver.py",
    ),
    Mutation(
        "tremor twice as wide",
        SRC + "physics/tremor.py",
        "decay = math.pi * width_hz",
        "decay = 2.0 * math.pi * width_hz",
        "unit/test_tremor.py",
    ),
    Mutation("spread of tau 0.30", SRC + "physics/fingers.py", "(0.38, 0.35)", "(0.38, 0.30)", "unit/test_fingers.py"),
    Mutation(
        "sensor noise over half the band",
        SRC + "parameters/plant.py",
        "math.sqrt(math.pi / 2.0 * self",
        "math.sqrt(math.pi / 4.0 * self",
        "unit/test_sensor.py unit/test_blocks.py reference/test_linear_bench.py",
    ),
    Mutation(
        "converter rounds down",
        SRC + "sensing/force_sensor.py",
        "(force_n * per_step + ROUND) - ROUND",
        "(force_n * per_step - 0.5 + ROUND) - ROUND",
        "unit/test_sensor.py unit/test_bench_closed_form.py",
    ),
    Mutation(
        "lookup table off by one cell",
        SRC + "loop/kernel/lowering.py",
        "cells = (size - 1) /",
        "cells = size /",
        "unit/test_lookup.py unit/test_switch.py",
    ),
    Mutation(
        "half the jitter",
        SRC + "loop/kernel/irregular_ticks.py",
        "jitter * abs(normal)",
        "0.5 * jitter * abs(normal)",
        "unit/test_switch.py unit/test_switch.py",
    ),
    Mutation(
        "notch 10 % too shallow",
        SRC + "control/notch.py",
        "t = math.tan(",
        "depth = 1.1 * depth\n    t = math.tan(",
        "unit/test_filtered_pi.py unit/test_retune_notch.py unit/test_filtered_pi.py",
    ),
    Mutation(
        "overdrive beyond the drive",
        SRC + "control/lookup.py",
        "inverse, 0.0), largest)",
        "inverse, 0.0), 2.0 * largest)",
        "unit/test_lookup.py firmware/test_board_law.py",
    ),
    Mutation(
        "converter's rms over sqrt 6",
        SRC + "analysis/disturbance_spectrum.py",
        "/ math.sqrt(12.0)",
        "/ math.sqrt(6.0)",
        "reference/test_linear_noise.py reference/test_linear_bench.py",
    ),
    Mutation(
        "delay margin of the first crossing",
        SRC + "analysis/margins.py",
        "float(np.min(further_s))",
        "float(further_s[0])",
        "reference/test_linear_closed_form.py reference/test_linear_time_domain.py reference/test_linear_bench.py",
    ),
    Mutation(
        "interval of 90 %, not 95",
        SRC + "identification/estimate.py",
        "(1 + confidence) / 2",
        "confidence",
        "unit/test_identification.py",
    ),
    Mutation(
        "Q from a tap 10 % low",
        SRC + "identification/matrix_pencil.py",
        "np.exp(-0.5 * angle / q)",
        "np.exp(-0.45 * angle / q)",
        "unit/test_modes.py",
    ),
    Mutation(
        "threshold at 150 Hz",
        SRC + "perception/detection_thresholds.py",
        "150.0: 0.18",
        "150.0: 0.25",
        "unit/test_perception_weighting.py unit/test_perception_weighting.py reference/test_perception_examples.py",
    ),
    Mutation(
        "leaves 4 % too stiff",
        SRC + "hardware/sensor/springs.py",
        "thickness**3 / 12,",
        "thickness**3 / 11.5,",
        "unit/test_springs.py",
    ),
    Mutation(
        "envelope of 2Q, not Q",
        SRC + "hardware/plate/drive_requirements.py",
        "return quality_factor / (math.pi",
        "return 2 * quality_factor / (math.pi",
        "unit/test_plate_envelope.py",
    ),
    Mutation(
        "Weibull exponent b, not 1/b",
        SRC + "experiments/psychometric.py",
        "ratio ** (1.0 / b)",
        "ratio**b",
        "experiments/test_report.py",
    ),
    Mutation(
        "QUEST's slope 10 % low",
        SRC + "experiments/adaptive_methods.py",
        "beta = -math.log(math.sqrt(2.0 * math.pi) * spread)",
        "beta = -math.log(1.1 * math.sqrt(2.0 * math.pi) * spread)",
        "experiments/test_methods.py",
    ),
    Mutation(
        "dispersion over n - 1",
        SRC + "experiments/psychometric.py",
        "level.size - 2) <= 0",
        "level.size - 1) <= 0",
        "experiments/test_report.py",
    ),
    Mutation(
        "t of n in intervals of groups",
        SRC + "experiments/study_summary.py",
        "COVERAGE, n - 1)",
        "COVERAGE, n)",
        "experiments/test_report.py",
    ),
    Mutation(
        "a fifth before a hit",
        SRC + "identification/hit_onsets.py",
        "BEFORE = 0.1",
        "BEFORE = 0.2",
        "unit/test_hits.py",
    ),
    Mutation(
        "bounces above 12 %", SRC + "identification/hits.py", "BOUNCE = 0.1", "BOUNCE = 0.12", "unit/test_hits.py"
    ),
    Mutation("rings above 1.2 %", SRC + "identification/hits.py", "LEFT = 0.01", "LEFT = 0.012", "unit/test_hits.py"),
    Mutation(
        "spread of stiffness 0.33",
        SRC + "physics/fingers.py",
        "(1000.0, 0.35)",
        "(1000.0, 0.33)",
        "unit/test_fingers.py",
    ),
]


def main() -> int:
    words, rows = sys.argv[1:], []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        for name in subprocess.check_output(["git", "ls-files"], cwd=ROOT, text=True).split("\n")[:-1]:
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name)
        for each in MUTATIONS:
            if not words or any(word in each.name for word in words):
                rows.append((each.name, each.file, tried(each, copy)))
                print(*rows[-1], sep=" | ", flush=True)
    survived = sum(not test for _, _, test in rows)
    if not words:
        lines = [f"| {name} | `{file}` | {test or '**survived**'} |\n" for name, file, test in rows]
        head = f"{len(rows) - survived} of {len(rows)} are caught (`benchmarks/mutations.py`).\n\n"
        text = head + "| wrong | in | caught by |\n|---|---|---|\n" + "".join(lines)
        (ROOT / "benchmarks" / "results" / "mutations.md").write_text(f"# Mutations\n\n{text}")
    return int(survived > 0)


def tried(mutation: Mutation, copy: Path) -> str:
    """Return the first test that fails with a mutation, nothing if it survives."""
    file = copy / mutation.file
    right = file.read_text()
    if right.count(mutation.old) != 1:
        raise SystemExit(f"{mutation.name}: {mutation.file} has {mutation.old!r} {right.count(mutation.old)} times")
    file.write_text(right.replace(mutation.old, mutation.new))
    tests = [f"tests/{each}" for each in mutation.tests.split()]
    options = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
    environment = os.environ | {"PYTHONPATH": str(copy / "src")}
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *tests],
        cwd=copy,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    file.write_text(right)
    if ran.returncode not in (0, 1):
        raise SystemExit(f"{mutation.name}: {ran.stdout[-2000:]}{ran.stderr[-2000:]}")
    found = re.search(r"^(?:FAILED|ERROR) tests/(\S+)", ran.stdout, re.MULTILINE)
    return found[1] if found else ""


if __name__ == "__main__":
    sys.exit(main())
